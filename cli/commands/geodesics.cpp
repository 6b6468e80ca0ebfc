// kinemesh geodesics: distances and shortest paths over a surface.
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/formats/mesh_formats.h"
#include "cli/commands/commands.h"
#include "config/output_file.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/geodesics/geodesic_output.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/landmarks.h"
#include "report/distance_view.h"

namespace kinemesh::cli {
namespace {

struct Arguments {
  std::string mesh, output;
  std::vector<std::string> from, to;
  GeodesicOptions geodesics;
  ReadOptions read;
};

SurfacePoint point_of(const std::string& text, const Topology& topology) {
  if (const std::optional<SurfacePoint> point = parse_place(text, topology)) return *point;
  throw UsageError({.what = "'" + text + "' names no point of the mesh, which has " +
                            count_of(topology.vertex_count(), "vertex", "vertices") + " and " +
                            count_of(topology.face_count(), "face"),
                    .remedy = "Give a vertex that belongs to a face by its number from 0, or a "
                              "point as FACE:B0:B1:B2 with weights that add up to 1"});
}

std::vector<SurfacePoint> points_of(const std::vector<std::string>& words,
                                    const Topology& topology) {
  std::vector<SurfacePoint> points;
  for (const std::string& word : words) points.push_back(point_of(word, topology));
  return points;
}

void write_output(const Arguments& args, const Mesh& mesh, const GeodesicField& field,
                  const std::vector<GeodesicPath>& paths, Terminal& terminal) {
  const std::filesystem::path path = args.output;
  if (lower(path.extension().string()) == ".png") {
    DistanceViewOptions view;
    view.title =
        "Distance over the surface of " + std::filesystem::path(args.mesh).filename().string();
    view.subtitle = "from " + join(args.from, ", ", " and ") +
                    (args.to.empty() ? "" : "; shortest paths to " + join(args.to, ", ", " and "));
    draw_distances(mesh, field, paths, view, terminal.run).write_png(path);
    return;
  }
  OutputSet files;
  add_distance_files(files, path, mesh, field, paths);
  files.commit();
}

nlohmann::ordered_json summary(const Arguments& args, const GeodesicField& field,
                               const std::vector<GeodesicPath>& paths, double seconds) {
  std::size_t reached = 0;
  double longest = 0.0;
  for (const double d : field.distances) {
    if (!std::isfinite(d)) continue;
    ++reached;
    longest = std::max(longest, d);
  }
  nlohmann::ordered_json json{{"mesh", args.mesh},
                              {"output", args.output},
                              {"vertices", field.distances.size()},
                              {"reached", reached},
                              {"longest_mm", longest},
                              {"seconds", seconds},
                              {"windows", field.diagnostics.windows},
                              {"degenerate_faces", field.diagnostics.degenerate_faces}};
  json["targets"] = nlohmann::ordered_json::array();
  for (std::size_t t = 0; t < field.target_distances.size(); ++t) {
    nlohmann::ordered_json target{{"to", args.to[t]}};
    const double d = field.target_distances[t];
    target["distance_mm"] = std::isfinite(d) ? nlohmann::ordered_json(d) : nullptr;
    if (t < paths.size()) target["points"] = paths[t].points.size();
    json["targets"].push_back(std::move(target));
  }
  return json;
}

std::string in_words(const nlohmann::ordered_json& s) {
  const auto longest = s["longest_mm"].get<double>();
  const bool usual = longest == 0.0 || (longest >= 0.01 && longest < 1e9);
  std::string text = std::to_string(s["reached"].get<std::size_t>()) + " of " +
                     count_of(s["vertices"].get<std::size_t>(), "vertex", "vertices") +
                     " reached, the furthest at " +
                     (usual ? format_fixed(longest, 3) : format_number(longest)) + " mm; " +
                     format_fixed(1e3 * s["seconds"].get<double>(), 1) + " ms";
  if (const auto faces = s["degenerate_faces"].get<std::size_t>(); faces > 0) {
    text += "\n" + count_of(faces, "triangle") + " without area mended by lengthening edges";
  }
  for (const auto& target : s["targets"]) {
    text += "\nto " + target["to"].get<std::string>() + ": " +
            (target["distance_mm"].is_null()
                 ? "no path within the radius or on the same piece of the mesh"
                 : format_number(target["distance_mm"].get<double>()) + " mm");
  }
  return text;
}

ExitCode run_geodesics(const Arguments& args, Terminal& terminal) {
  check_distance_path(args.output);
  refuse_to_replace({args.mesh}, {args.output, path_file(args.output)});
  const Mesh mesh = read_mesh(all_formats(), args.mesh, args.read, terminal.run);
  if (mesh.topology->face_count() == 0) {
    throw NoResultError({.what = "the mesh has no faces to measure on", .file = args.mesh});
  }
  const GeodesicSolver solver(mesh);
  const auto begin = std::chrono::steady_clock::now();
  const GeodesicField field = solver.solve(points_of(args.from, *mesh.topology), args.geodesics,
                                           terminal.run, points_of(args.to, *mesh.topology));
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
  std::vector<GeodesicPath> paths;
  if (args.geodesics.method != GeodesicMethod::heat) {
    for (std::size_t t = 0; t < args.to.size(); ++t) {  // empty where no path leads
      paths.push_back(std::isfinite(field.target_distances[t]) ? solver.path_to_target(field, t)
                                                               : GeodesicPath{});
    }
  }
  write_output(args, mesh, field, paths, terminal);
  const nlohmann::ordered_json result = summary(args, field, paths, spent.count());
  terminal.print(terminal.json ? result.dump(2) : in_words(result));
  return ExitCode::done;
}

}  // namespace

CommandSpec geodesics_command() {
  return {.path = "geodesics",
          .summary = "Measure distances and shortest paths over a surface",
          .example =
              "kinemesh geodesics face.ply --from 120 --to 987 -o distances.csv\n"
              "kinemesh geodesics cat.off --from 0 17 --method heat -o distances.png",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positional("MESH", args->mesh, "Mesh file (PLY, OFF, OBJ, …; its first frame)");
            line.words("--from", args->from, "VERTEX",
                       "Where to measure from: vertices by number from 0, or points inside faces "
                       "as FACE:B0:B1:B2; of several, the nearest counts",
                       true);
            line.words("--to", args->to, "VERTEX",
                       "Write the shortest path to these as well (not with --method heat)");
            line.option(
                "-o,--output", args->output, "OUT",
                "OUT.csv, .npz, .ply (distances as vertex quality) or .png (with isolines); "
                "paths of --to go to OUT_path.csv or OUT_path.ply beside it",
                true);
            line.parameters([args](ParameterSet& p) {
              args->geodesics.declare(p);
              args->read.declare(p);
            });
            line.json_output();
            return [args](Terminal& terminal) { return run_geodesics(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
