// kinemesh evaluate map: geodesic errors of maps whose truth is known.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/map_evaluation.h"
#include "analysis/map_evaluation_view.h"
#include "cli/commands/commands.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/surface_map_io.h"

namespace kinemesh::cli {
namespace {

struct Arguments {
  std::vector<std::string> maps, truth, curves;
  std::string mirrored, target, source;
  MapEvaluationOptions evaluation;
  ReadOptions read;
};

/// A .csv of pairs has other columns than a surface map.
bool is_surface_map(const std::string& path) {
  const std::string extension = lower(std::filesystem::path(path).extension().string());
  if (extension == ".json" || extension == ".npz") return true;
  return extension == ".csv" && read_file(path).find("vertex,face,b0") != std::string::npos;
}

MapTruth read_truth(const Arguments& args, std::size_t source_vertices, const Mesh& target) {
  if (args.truth.size() == 2) {
    const std::size_t n = target.topology->vertex_count();
    return truth_from_lists(
        read_vertex_list(args.truth[0], source_vertices), read_vertex_list(args.truth[1], n),
        args.mirrored.empty() ? std::vector<VertexIndex>() : read_vertex_list(args.mirrored, n),
        *target.topology);
  }
  if (args.truth.size() != 1) {
    throw UsageError({.what = "--truth takes a map or a file of pairs, or one list for each mesh"});
  }
  if (is_surface_map(args.truth[0])) {
    const SurfaceMap truth = read_surface_map(args.truth[0]);
    std::optional<SurfaceMap> mirrored;
    if (!args.mirrored.empty()) mirrored = read_surface_map(args.mirrored);
    return truth_from_map(truth, mirrored ? &*mirrored : nullptr);
  }
  if (args.source.empty()) {
    throw UsageError(
        {.what = "pairs of landmarks need the source mesh", .remedy = "Name it with --source"});
  }
  const Mesh source = read_mesh(builtin_mesh_formats(), args.source, args.read);
  return truth_from_pairs(read_landmark_pairs(args.truth[0], *source.topology, *target.topology),
                          *source.topology);
}

Mesh target_of(const Arguments& args, const SurfaceMap& map) {
  const std::string path = args.target.empty() ? map.target_name : args.target;
  if (path.empty()) {
    throw UsageError(
        {.what = "the map does not say which mesh it leads to", .remedy = "Name it with --target"});
  }
  return read_mesh(builtin_mesh_formats(), path, args.read);
}

nlohmann::ordered_json json_of(const MapErrors& e) {
  return {{"places", e.sorted.size()},
          {"unmapped", e.unmapped},
          {"mean", e.mean},
          {"median", e.median},
          {"percentile_75", e.p75},
          {"percentile_90", e.p90},
          {"percentile_95", e.p95},
          {"percentile_99", e.p99},
          {"worst", e.worst},
          {"area_under_curve", e.area_under_curve}};
}

nlohmann::ordered_json json_of(const std::string& map, const MapEvaluation& e) {
  nlohmann::ordered_json json{{"map", map}, {"root_area_mm", e.root_area_mm}};
  json["errors"] = json_of(e.errors);
  if (e.mirrored) json["against_mirrored"] = json_of(*e.mirrored);
  if (e.either) json["mirrored_allowed"] = json_of(*e.either);
  if (e.confidence_ratio > 0.0) json["confidence_ratio"] = e.confidence_ratio;
  return json;
}

std::string row_of(const std::string& name, const MapErrors& e) {
  std::string row = "\n";
  for (const double value : {e.mean, e.median, e.p90, e.p95, e.worst}) {
    row += format_fixed(value, 4) + "  ";
  }
  return row + format_fixed(e.area_under_curve, 3) + "  " + name +
         (e.unmapped > 0 ? " (" + std::to_string(e.unmapped) + " unmapped)" : "");
}

std::string curves_csv(const LineChart& chart) {
  std::string csv = "error_over_root_area";
  for (const Series& s : chart.series) csv += ",\"" + s.label + "\"";
  for (std::size_t k = 0; k < chart.series[0].x.size(); ++k) {
    csv += "\n" + format_number(chart.series[0].x[k]);
    for (const Series& s : chart.series) csv += "," + format_number(s.y[k] / 100.0);
  }
  return csv + "\n";
}

void write_curves(const Arguments& args, const LineChart& chart) {
  OutputSet files;
  for (const std::string& path : args.curves) {
    const std::string extension = lower(std::filesystem::path(path).extension().string());
    if (extension == ".csv") {
      files.add(path, curves_csv(chart));
    } else if (extension == ".svg") {
      files.add(path, canvas_of(chart, 720, 460).svg({.title = chart.title}));
    } else if (extension == ".png") {
      files.add(path, encode_png(canvas_of(chart, 720, 460).raster(2.0)));
    } else {
      throw UsageError({.what = "error curves are .svg, .png or .csv files", .file = path});
    }
  }
  files.commit();
}

ExitCode run_evaluate(const Arguments& args, Terminal& terminal) {
  std::vector<MapEvaluation> evaluations;
  std::vector<std::string> names;
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  std::string text = "errors over √area\nmean    median  90 %    95 %    worst   area   map";
  for (const std::string& path : args.maps) {
    const double part = static_cast<double>(names.size()) / static_cast<double>(args.maps.size());
    const SurfaceMap map = read_surface_map(path);
    const Mesh target = target_of(args, map);
    const MapTruth truth = read_truth(args, map.points.size(), target);
    const RunContext ctx =
        terminal.run.part(part, part + 1.0 / static_cast<double>(args.maps.size()), path);
    evaluations.push_back(evaluate_map(map, truth, target, args.evaluation, ctx));
    names.push_back(std::filesystem::path(path).filename().string());
    const MapEvaluation& e = evaluations.back();
    json.push_back(json_of(path, e));
    text += row_of(names.back(), e.errors);
    if (e.mirrored) text += row_of("… against the mirrored truth", *e.mirrored);
    if (e.either) text += row_of("… the mirrored truth allowed at each place", *e.either);
  }
  write_curves(args, error_curves(names, evaluations, args.evaluation.cutoff));
  terminal.print(terminal.json ? json.dump(2) : text);
  return ExitCode::done;
}

}  // namespace

CommandSpec evaluate_map_command() {
  return {.path = "evaluate map",
          .summary = "Measure the geodesic errors of maps between surfaces against the truth",
          .example =
              "kinemesh evaluate map a_to_b.csv --truth true.csv --curve errors.svg\n"
              "kinemesh evaluate map ours.csv theirs.csv --truth cat0.vts cat1.vts "
              "--mirrored cat1.sym.vts --target cat1.off --curve errors.png",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positionals("MAP", args->maps, "Maps from the same source to the same target");
            line.words("--truth", args->truth, "FILE",
                       "The true map; or pairs of landmarks, one pair a line; or a list of "
                       "vertices for each mesh, source first, line k of one belonging to line k "
                       "of the other (.vts: counted from 1, otherwise from 0)",
                       true);
            line.option("--mirrored", args->mirrored, "FILE",
                        "The same for the mirror image on the target: shows errors with it, too");
            line.option("--target", args->target, "MESH",
                        "The target mesh; by default the one that the map names");
            line.option("--source", args->source, "MESH",
                        "The source mesh, for a truth given as pairs of landmarks");
            line.option("--curve", args->curves, "OUT",
                        "Error curves: .svg, .png or .csv; may be given several times");
            line.parameters([args](ParameterSet& p) {
              args->evaluation.declare(p);
              args->read.declare(p);
            });
            line.json_output();
            return [args](Terminal& terminal) { return run_evaluate(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
