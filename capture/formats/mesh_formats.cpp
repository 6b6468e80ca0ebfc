#include "capture/formats/mesh_formats.h"

#include <algorithm>
#include <numeric>

#include "capture/c3d/writer.h"
#include "capture/formats/session_csv.h"
#include "capture/formats/table_text.h"
#include "capture/formats/trc.h"
#include "capture/session.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

namespace fs = std::filesystem;

std::string vertex_name_of(const Marker& marker) {
  return marker.subject.empty() ? marker.label : marker.subject + ":" + marker.label;
}

/// Positions of one marker in all frames: linear between measured frames, held at both ends.
/// Returns the number of frames that were filled so.
std::size_t fill_linearly(const MarkerSequence& take, std::size_t marker, std::size_t vertex,
                          MeshData& data) {
  const std::size_t frames = take.frame_count();
  const auto at = [&](std::size_t f) {
    return Eigen::Map<Eigen::Vector3f>(data.positions.data() +
                                       3 * (f * data.vertex_count + vertex));
  };
  std::size_t filled = 0, previous = frames;
  for (std::size_t f = 0; f <= frames; ++f) {
    const bool valid = f < frames && take.valid(f, marker);
    if (f < frames && !valid) continue;
    const std::size_t begin = previous == frames ? 0 : previous + 1;
    for (std::size_t g = begin; g < f; ++g) {
      const std::size_t from = previous == frames ? f : previous;
      const std::size_t to = f == frames ? previous : f;
      const float t =
          to > from ? static_cast<float>(g - from) / static_cast<float>(to - from) : 0.0F;
      at(g) = take.position(from, marker) +
              t * (take.position(to, marker) - take.position(from, marker));
      data.filled[g * data.vertex_count + vertex] = 1;
      ++filled;
    }
    if (f < frames) {
      at(f) = take.position(f, marker);
      data.filled[f * data.vertex_count + vertex] = take.filled(f, marker) ? 1 : 0;
      previous = f;
    }
  }
  return filled;
}

/// The markers; the points without labels where there is nothing else.
MarkerKind kind_to_show(const MarkerSequence& take) {
  const bool any = std::ranges::count(take.markers(), MarkerKind::marker, &Marker::kind) > 0;
  return any ? MarkerKind::marker : MarkerKind::unlabelled;
}

MeshData points_of(const MarkerSequence& take, const std::string& file) {
  std::vector<std::size_t> chosen;
  std::size_t never_seen = 0;
  const MarkerKind kind = kind_to_show(take);
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind != kind) continue;
    bool seen = false;
    for (std::size_t f = 0; f < take.frame_count() && !seen; ++f) seen = take.valid(f, m);
    if (seen) chosen.push_back(m);
    never_seen += seen ? 0 : 1;
  }
  if (chosen.empty()) {
    throw InputError(
        {.what = "the recording holds no marker with a measured position", .file = file});
  }
  MeshData data;
  data.allocate(take.frame_count(), chosen.size());
  data.filled = Buffer<uint8_t>(take.frame_count() * chosen.size(), 0);
  std::size_t filled = 0;
  for (std::size_t v = 0; v < chosen.size(); ++v) {
    filled += fill_linearly(take, chosen[v], v, data);
    data.vertex_names.push_back(vertex_name_of(take.markers()[chosen[v]]));
  }
  if (kind == MarkerKind::unlabelled) {
    data.warnings.emplace_back(
        "no point has a label; 'kinemesh c3d process --template' gives them");
  }
  if (!take.uncertainty().empty()) {
    data.uncertainty = Buffer<float>(take.frame_count() * chosen.size());
    for (std::size_t i = 0; i < data.uncertainty.size(); ++i) {
      data.uncertainty[i] =
          take.uncertainty()[take.sample(i / chosen.size(), chosen[i % chosen.size()])];
    }
  }
  if (never_seen > 0) {
    data.warnings.push_back(count_of(never_seen, "marker") + " never measured, left out");
  }
  if (filled > 0) {
    data.warnings.push_back(count_of(filled, "sample") +
                            " in gaps interpolated linearly; 'kinemesh convert' fills them better");
  }
  data.unit = LengthUnit::mm;
  data.rate_hz = take.rate_hz;
  data.first_frame = take.first_frame;
  data.events = take.events;
  return data;
}

MeshData read_points(const fs::path& path, const ReadOptions& options, const RunContext& ctx) {
  SessionReadOptions session;
  session.c3d.unstated = options;
  return points_of(read_session(path, session, ctx), path.string());
}

/// C3D and TRC have no other sign of a gap than the origin, for most programs that read them.
void note_origin(const AnimatedMesh& mesh, WriteReport& report) {
  std::size_t at_origin = 0;
  const auto p = mesh.positions();
  for (std::size_t i = 0; i < p.size(); i += 3) {
    at_origin += p[i] == 0 && p[i + 1] == 0 && p[i + 2] == 0 ? 1 : 0;
  }
  if (at_origin == 0) return;
  report.notes.push_back(count_of(at_origin, "sample") +
                         " at exactly (0, 0, 0) will be read as gaps");
}

WriteReport write_c3d_points(const AnimatedMesh& mesh, const fs::path& path, const WriteOptions&,
                             OutputSet& files, const RunContext&) {
  std::vector<C3dLoss> losses;
  files.add(path, encode_c3d(markers_of(mesh), {.storage = "float", .unit = "mm"}, &losses));
  WriteReport report;
  for (const C3dLoss& loss : losses) report.notes.push_back(loss.message);
  if (mesh.first_frame < 1) {
    report.notes.push_back("the first frame is " + std::to_string(mesh.first_frame) +
                           "; C3D counts from 1, which it becomes");
  }
  note_origin(mesh, report);
  return report;
}

WriteReport write_trc_points(const AnimatedMesh& mesh, const fs::path& path, const WriteOptions&,
                             OutputSet& files, const RunContext& ctx) {
  OutputFile file(path);
  write_trc(markers_of(mesh), file, ctx);
  files.add(std::move(file));
  WriteReport report;
  note_origin(mesh, report);
  return report;
}

WriteReport write_csv_points(const AnimatedMesh& mesh, const fs::path& path, const WriteOptions&,
                             OutputSet& files, const RunContext& ctx) {
  OutputFile file(path);
  write_session_csv(markers_of(mesh), file, ctx);
  files.add(std::move(file));
  return {};
}

Format point_format(const char* name, const char* description, const char* exactness, Keeps keeps,
                    Format::Write write) {
  Format format = make_format(name, std::string(".") + name, description, keeps, exactness);
  format.fixed_unit = true;
  format.read = read_points;
  format.write = std::move(write);
  return format;
}

}  // namespace

MarkerSequence markers_of(const AnimatedMesh& mesh) {
  std::vector<Marker> markers(mesh.vertex_count());
  for (std::size_t v = 0; v < markers.size(); ++v) {
    const QualifiedLabel label =
        split_label(mesh.vertex_names.empty() ? "v" + std::to_string(v) : mesh.vertex_names[v]);
    markers[v].subject = label.subject;
    markers[v].label = label.label;
  }
  MarkerSequence take(mesh.frame_count(), std::move(markers), mesh.rate_hz);
  std::copy(mesh.positions().begin(), mesh.positions().end(), take.positions().begin());
  std::ranges::fill(take.residuals(), 0.0F);
  std::ranges::fill(take.camera_masks(), uint8_t{0});
  for (std::size_t i = 0; i < take.flags().size(); ++i) {
    const bool filled = !mesh.filled().empty() && mesh.filled()[i] != 0;
    take.flags()[i] = SampleFlag::valid | (filled ? SampleFlag::filled : 0);
  }
  if (!mesh.uncertainty().empty()) {
    take.add_uncertainty();
    std::copy(mesh.uncertainty().begin(), mesh.uncertainty().end(), take.uncertainty().begin());
  }
  take.first_frame = mesh.first_frame;
  take.events = mesh.events;
  return take;
}

void add_capture_formats(FormatRegistry& formats) {
  formats.add(point_format("c3d", "C3D, the vertices as markers", "every float",
                           {.faces = false,
                            .names = true,
                            .unit = true,
                            .rate = true,
                            .first_frame = true,
                            .events = true},
                           write_c3d_points));
  formats.add(
      point_format("trc", "TRC, the vertices as markers", "every float, as decimal text",
                   {.faces = false, .names = true, .unit = true, .rate = true, .first_frame = true},
                   write_trc_points));
  formats.add(point_format("csv", "CSV, the vertices as columns", "every float, as decimal text",
                           {.faces = false,
                            .names = true,
                            .unit = true,
                            .rate = true,
                            .first_frame = true,
                            .events = true,
                            .filled = true,
                            .uncertainty = true},
                           write_csv_points));
}

FormatRegistry all_formats() {
  FormatRegistry formats = builtin_mesh_formats();
  add_capture_formats(formats);
  return formats;
}

}  // namespace kinemesh
