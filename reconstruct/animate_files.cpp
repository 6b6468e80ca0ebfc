#include "reconstruct/animate_files.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/output_file.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "reconstruct/marker_places.h"
#include "reconstruct/output_names.h"
#include "report/error_view.h"
#include "report/gap_chart.h"
#include "report/image.h"

namespace kinemesh {
namespace {

namespace fs = std::filesystem;

std::string summary_of(const AnimateJob& job, const AnimateResult& r,
                       const std::vector<std::string>& outputs) {
  nlohmann::ordered_json json;
  json["scan"] = job.scan;
  json["session"] = job.session;
  json["places"] = job.places.empty() ? "found" : job.places;
  json["faces"] = r.scan.topology->face_count();
  json["faces_solved"] = r.drive.solved_faces;
  json["boundaries"] = r.openings;
  json["vertices"] = r.drive.animation.vertex_count();
  json["frames"] = r.drive.animation.frame_count();
  json["rate_hz"] = r.drive.animation.rate_hz;
  json["scan_scaled_by"] = r.scale;
  json["neutral_frame"] = r.neutral_frame;
  json["markers"] = r.registration.markers.size();
  json["registration_rms_mm"] = r.registration.rms_mm;
  json["reach_mm"] = r.drive.reach_mm;
  json["noise_mm"] = r.drive.noise_mm;
  json["largest_smoothing_mm"] = r.drive.largest_change_mm;
  for (std::size_t m = 0; m < r.labels.size(); ++m) {
    const double distance = r.registration.distance_mm[m];
    nlohmann::ordered_json marker{{"label", r.labels[m]}, {"attached", false}};
    if (std::isfinite(distance)) marker["distance_mm"] = distance;
    for (std::size_t k = 0; k < r.registration.kept.size(); ++k) {
      if (r.registration.kept[k] != m) continue;
      marker["attached"] = true;
      marker["error_rms_mm"] = r.drive.marker_error_mm[k];
    }
    json["marker_distances"].push_back(std::move(marker));
  }
  json["notes"] = r.notes;
  json["outputs"] = outputs;
  return json.dump(2) + "\n";
}

/// The scan with each marker where it stands in the neutral frame, coloured by its distance.
Canvas attachment_picture(const AnimateJob& job, const AnimateResult& r, const RunContext& ctx) {
  ColourScale scale;
  scale.high = 3.0;
  ErrorPanel panel{"markers in frame " + std::to_string(r.neutral_frame), r.scan.topology,
                   r.scan.positions};
  for (std::size_t m = 0; m < r.neutral.size(); ++m) {
    panel.spheres.push_back({.centre = r.neutral[m].cast<float>(),
                             .radius_px = 3.5F,
                             .colour = scale(std::abs(r.registration.distance_mm[m]))});
  }
  ErrorPanel plain{"where they are attached", r.scan.topology, r.scan.positions};
  for (const AttachedMarker& m : r.registration.markers) {
    plain.spheres.push_back(
        {.centre = position_of(m.point, *r.scan.topology, r.scan.positions).cast<float>(),
         .radius_px = 3.0F,
         .colour = colour_from_hex(0xd1242f)});
  }
  return draw_error_view({panel, plain},
                         {.title = fs::path(job.scan).filename().string(),
                          .subtitle = count_of(r.registration.markers.size(), "marker") +
                                      " attached, root mean square distance " +
                                      format_fixed(r.registration.rms_mm, 2) + " mm",
                          .value_label = "distance of a marker from the skin",
                          .high_mm = scale.high,
                          .columns = 2},
                         ctx);
}

}  // namespace

void AnimateFilesOptions::declare(ParameterSet& p) {
  reading.declare(p);
  animate.declare(p);
  writing.declare(p);
  p.group("pictures", "Pictures");
  p.flag("pictures", pictures, "draw the markers on the scan, and the scan at a few frames");
  sheet.declare(p);
}

void AnimateFilesOptions::validate() const {
  animate.validate();
  validate_options(*this);
}

AnimateFilesResult animate_files(const FormatRegistry& formats, const AnimateJob& job,
                                 const AnimateFilesOptions& options, const RunContext& ctx) {
  options.validate();
  const std::vector<fs::path> inputs{job.scan, job.session, job.places};
  refuse_to_replace(inputs, {job.output});
  const RunContext reading = ctx.part(0.0, 0.1, "reading");
  const Mesh scan = read_mesh(formats, job.scan, options.reading.c3d.unstated, reading);
  const MarkerSequence session = read_session(job.session, options.reading, reading);
  output_format(formats, job.output, options.writing, session.frame_count());
  PlacesSource places;
  if (!job.places.empty()) {
    // The file speaks of the scan's faces as they are in its file, before any were turned round.
    places = [&](const Mesh& in_mm, double scale) {
      const Mesh as_read{scan.topology, in_mm.positions, {}};
      return with_corners_of(
          read_marker_places(job.places, as_read, scale, options.animate.attach.marker_radius_mm),
          *scan.topology, *in_mm.topology);
    };
  }
  AnimateOptions animating = options.animate;
  animating.frames = options.writing.frames;
  AnimateFilesResult done;
  done.result = animate_scan(scan, session, places, animating, ctx.part(0.1, 0.8, "animating"));
  AnimateResult& result = done.result;
  result.drive.animation.provenance =
      provenance_of(job.program, job.command, job.options_toml, inputs);
  OutputSet files;
  const fs::path output(job.output), stem = stem_of_output(output);
  const WriteResult written = add_animation(formats, result.drive.animation, output,
                                            options.writing, files, ctx.part(0.8, 0.9, "writing"));
  done.outputs.push_back(written.files.front().string());
  if (written.files.size() > 1) done.outputs.push_back(written.files.back().string());
  const auto add = [&](const std::string& suffix, const std::string& content) {
    done.outputs.push_back(beside(stem, suffix).string());
    files.add(beside(stem, suffix), content);
  };
  // The places that were read stay as they are.
  std::error_code none;
  if (job.places.empty() || !fs::equivalent(job.places, beside(stem, "_points.csv"), none)) {
    add("_points.csv", marker_places_csv(with_corners_of(result.registration.markers,
                                                         *result.scan.topology, *scan.topology)));
  }
  if (options.pictures) {
    const Canvas attachment = attachment_picture(job, result, ctx);
    add("_attachment.png", encode_png(attachment.raster(1.5)));
    ContactSheetOptions sheet = options.sheet;
    sheet.title = fs::path(job.scan).filename().string();
    sheet.subtitle = "driven by " + count_of(result.registration.markers.size(), "marker") +
                     " of " + fs::path(job.session).filename().string();
    const Canvas frames = draw_contact_sheet(result.drive.animation, sheet, ctx).sheet;
    add("_frames.png", encode_png(frames.raster(png_scale(frames))));
  }
  done.outputs.push_back(beside(stem, "_summary.json").string());
  done.json = summary_of(job, result, done.outputs);
  files.add(beside(stem, "_summary.json"), done.json);
  refuse_to_replace(inputs, files.paths());
  files.commit();
  ctx.progress(1.0);
  return done;
}

}  // namespace kinemesh
