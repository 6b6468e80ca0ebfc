// kinemesh info: what is in a mesh, an animation, a numbered sequence or a recording.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/formats/mesh_formats.h"
#include "cli/commands/commands.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/sequence.h"
#include "mesh/mesh_info.h"

namespace kinemesh::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string unit_text(const AnimationFile& file, const ReadOptions& options) {
  return file.unit ? std::string(name_of(*file.unit)) + " (as the file says)"
                   : std::string(name_of(options.unit)) + " (assumed: the file does not say)";
}

std::string vector_text(const Eigen::Vector3f& v) {
  return format_fixed(v.x(), 2) + " " + format_fixed(v.y(), 2) + " " + format_fixed(v.z(), 2);
}

std::string line_of(const char* label, const std::string& value) {
  std::string out = label;
  out.resize(14, ' ');
  return out + value + "\n";
}

std::string timing_text(const MeshInfo& info) {
  std::string out = std::to_string(info.frames);
  if (info.frames > 1 || info.first_frame != 1) {
    out += " (" + std::to_string(info.first_frame) + " to " +
           std::to_string(info.first_frame + static_cast<int64_t>(info.frames) - 1) + ")";
  }
  if (info.rate_hz > 0) {
    out += " at " + format_number(info.rate_hz) + " Hz, " + format_fixed(info.duration_s, 3) + " s";
  } else if (info.frames > 1) {
    out += ", rate not known (give it with --rate)";
  }
  return out;
}

std::string surface_text(const MeshInfo& info) {
  if (info.faces == 0) return line_of("surface", "none: points without faces");
  std::vector<std::string> loops;
  for (const std::size_t size : info.boundaries) loops.push_back(std::to_string(size));
  if (loops.size() > 12) {
    loops.resize(12);
    loops.emplace_back("…");
  }
  std::string out = line_of("manifold", info.manifold ? "yes" : "no");
  out += line_of(
      "components",
      std::to_string(info.components) +
          (info.isolated_vertices > 0
               ? " and " + count_of(info.isolated_vertices, "vertex", "vertices") + " without faces"
               : ""));
  out += line_of("boundaries", std::to_string(info.boundaries.size()) +
                                   (loops.empty() ? "" : " (vertices: " + join(loops, ", ") + ")"));
  out += line_of("genus", info.genus ? std::to_string(*info.genus) : "undefined (not manifold)");
  out += line_of("mean edge", format_fixed(info.mean_edge_mm, 3) + " mm");
  out += line_of("worst", "triangle (0-based), frame, smallest angle, aspect (1 is best)");
  for (const WorstTriangle& t : info.worst) {
    out += line_of("", std::to_string(t.face) + ", " +
                           std::to_string(info.first_frame + static_cast<int64_t>(t.frame)) + ", " +
                           format_fixed(t.smallest_angle_deg, 2) + "°, " +
                           (std::isfinite(t.aspect) ? format_fixed(t.aspect, 1) : "infinite"));
  }
  return out;
}

std::string info_text(const AnimationFile& file, const MeshInfo& info, const ReadOptions& options) {
  std::string out = line_of(
      "format",
      file.format + (file.files.size() > 1 ? ", " + count_of(file.files.size(), "file") : ""));
  out += line_of(
      "vertices",
      std::to_string(info.vertices) +
          (info.named_vertices > 0 ? " (" + std::to_string(info.named_vertices) + " named)" : ""));
  out += line_of("faces", std::to_string(info.faces));
  out += line_of("frames", timing_text(info));
  out += line_of("unit", unit_text(file, options));
  out += line_of("box", vector_text(info.low) + " to " + vector_text(info.high) + " mm");
  if (info.filled_samples > 0) {
    out += line_of("filled", std::to_string(info.filled_samples) + " of " +
                                 std::to_string(info.samples) + " samples");
  }
  if (info.events > 0) out += line_of("events", std::to_string(info.events));
  return out + surface_text(info);
}

Json info_json(const AnimationFile& file, const MeshInfo& info, const ReadOptions& options) {
  Json worst = Json::array();
  for (const WorstTriangle& t : info.worst) {
    Json aspect = nullptr;  // JSON knows no infinity
    if (std::isfinite(t.aspect)) aspect = t.aspect;
    worst.push_back({{"face", t.face},
                     {"frame", info.first_frame + static_cast<int64_t>(t.frame)},
                     {"smallest_angle_deg", t.smallest_angle_deg},
                     {"aspect", aspect}});
  }
  Json genus = nullptr;
  if (info.genus) genus = *info.genus;
  Json rate = nullptr, duration = nullptr;
  if (info.rate_hz > 0) {
    rate = info.rate_hz;
    duration = info.duration_s;
  }
  return {
      {"format", file.format},
      {"files", file.files.size()},
      {"vertices", info.vertices},
      {"faces", info.faces},
      {"edges", info.edges},
      {"frames", info.frames},
      {"first_frame", info.first_frame},
      {"rate_hz", rate},
      {"duration_s", duration},
      {"unit", name_of(file.unit.value_or(options.unit))},
      {"unit_known", file.unit.has_value()},
      {"box_mm",
       {{info.low.x(), info.low.y(), info.low.z()}, {info.high.x(), info.high.y(), info.high.z()}}},
      {"components", info.components},
      {"isolated_vertices", info.isolated_vertices},
      {"boundaries", info.boundaries},
      {"euler_characteristic", info.euler_characteristic},
      {"genus", genus},
      {"manifold", info.manifold},
      {"mean_edge_mm", info.mean_edge_mm},
      {"worst_triangles", worst},
      {"filled_samples", info.filled_samples},
      {"named_vertices", info.named_vertices},
      {"events", info.events}};
}

/// A numbered sequence whose frames differ in topology: each frame by itself.
void print_sequence(const MeshSequence& sequence, Terminal& terminal) {
  Json frames = Json::array();
  std::string text = line_of("frames", std::to_string(sequence.frames.size()) +
                                           " of differing topology: vertices, faces, manifold");
  for (const Mesh& frame : sequence.frames) {
    const Topology& t = *frame.topology;
    frames.push_back({{"vertices", t.vertex_count()},
                      {"faces", t.face_count()},
                      {"components", t.component_count()},
                      {"boundaries", t.boundary_loops().size()},
                      {"manifold", t.is_manifold()}});
    text += line_of("", std::to_string(t.vertex_count()) + ", " + std::to_string(t.face_count()) +
                            ", " + (t.is_manifold() ? "yes" : "no"));
  }
  Json rate = nullptr;
  if (sequence.rate_hz > 0) rate = sequence.rate_hz;
  terminal.print(terminal.json ? Json{{"rate_hz", rate}, {"frames", frames}}.dump(2) : text);
}

ExitCode show(const std::string& path, const ReadOptions& options, Terminal& terminal) {
  const FormatRegistry registry = all_formats();
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored) || is_number_pattern(path)) {
    const MeshSequence sequence = read_mesh_sequence(registry, path, options, terminal.run);
    const auto differs = [&](const Mesh& m) { return m.topology != sequence.frames[0].topology; };
    if (std::ranges::any_of(sequence.frames, differs)) {
      print_sequence(sequence, terminal);
      return ExitCode::done;
    }
  }
  const AnimationFile file = read_animation_file(registry, path, options, terminal.run);
  const MeshInfo info = mesh_info_of(file.mesh, 5, terminal.run);
  terminal.print(terminal.json ? info_json(file, info, options).dump(2)
                               : info_text(file, info, options));
  return ExitCode::done;
}

}  // namespace

CommandSpec info_command() {
  return {
      .path = "info",
      .summary = "Show size, timing, extent, topology and worst triangles of a mesh or recording",
      .example =
          "kinemesh info face.ply\nkinemesh info frames/ --rate 60\nkinemesh info scan.obj --unit "
          "m --json",
      .setup = [](CommandLine& line) -> Action {
        struct Arguments {
          std::string file;
          ReadOptions read;
        };
        auto args = std::make_shared<Arguments>();
        line.positional("FILE", args->file,
                        "Mesh, animation, folder or pattern of numbered files, or recording");
        line.parameters([args](ParameterSet& p) { args->read.declare(p); });
        line.json_output();
        return [args](Terminal& terminal) { return show(args->file, args->read, terminal); };
      }};
}

}  // namespace kinemesh::cli
