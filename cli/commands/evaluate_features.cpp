// kinemesh evaluate features: agreement of features with a true map, or with regions marked by
// hand.
#include <nlohmann/json.hpp>

#include "analysis/feature_consistency.h"
#include "analysis/feature_io.h"
#include "analysis/marked_regions.h"
#include "cli/commands/commands.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/surface_map_io.h"
#include "report/chart.h"

namespace kinemesh::cli {
namespace {

struct Arguments {
  std::string source, target, truth, mesh, curve;
  std::vector<std::string> regions;
  ConsistencyOptions consistency;
  ReadOptions read;
};

nlohmann::ordered_json json_of(const Consistency& c) {
  return {{"strict", c.strict}, {"strict_with_slack", c.slack}, {"nearest", c.nearest}};
}

std::string row_of(const std::string& name, const Consistency& c) {
  return "\n" + name + format_fixed(c.strict, 3) + "   " + format_fixed(c.slack, 3) + "   " +
         format_fixed(c.nearest, 3);
}

/// Share of the features with at most so large an error.
Series curve_of(const std::string& label, const std::vector<double>& errors, std::size_t colour) {
  Series series{label, {0.0}, {0.0}, series_colour(colour)};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    series.x.push_back(100.0 * errors[i]);
    series.y.push_back(100.0 * static_cast<double>(i + 1) / static_cast<double>(errors.size()));
  }
  return series;
}

void draw_curve(const std::string& path, const ConsistencyResult& result) {
  LineChart chart;
  chart.title = "Distance to the other's nearest feature";
  chart.x = {.label = "distance over the diagonal", .unit = "%", .low = 0.0, .high = 20.0};
  chart.y = {.label = "features", .unit = "%", .low = 0.0, .high = 100.0};
  chart.series = {curve_of("features", result.errors, 0),
                  curve_of("random vertices", result.random_errors, 1)};
  canvas_of(chart, 640, 420).write_png(path);
}

Mesh mesh_for(const Arguments& args, const FeatureSet& set) {
  const std::string path = args.mesh.empty() ? set.animation : args.mesh;
  if (path.empty()) {
    throw UsageError({.what = "the features do not say which mesh they are of",
                      .remedy = "Name it with --mesh"});
  }
  return read_mesh(builtin_mesh_formats(), path, args.read);
}

ExitCode compare_with_regions(const Arguments& args, Terminal& terminal) {
  const FeatureSet set = read_features(args.source);
  const Mesh mesh = mesh_for(args, set);
  const std::vector<double> marked =
      read_marked_regions({args.regions.begin(), args.regions.end()}, mesh.positions.size());
  std::vector<double> thresholds;
  for (std::size_t i = 0; i < args.regions.size(); ++i) {
    thresholds.push_back(static_cast<double>(i) / static_cast<double>(args.regions.size()));
  }
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  std::string text = "marked by more than   precision   recall";
  for (const RegionScore& s : compare_regions(set, mesh, marked, thresholds)) {
    rows.push_back({{"threshold", s.threshold}, {"precision", s.precision}, {"recall", s.recall}});
    text += "\n" + format_fixed(100 * s.threshold, 0) + " %\t\t\t" + format_fixed(s.precision, 3) +
            "       " + format_fixed(s.recall, 3);
  }
  terminal.print(terminal.json ? rows.dump(2) : text);
  return ExitCode::done;
}

ExitCode run_evaluate(const Arguments& args, Terminal& terminal) {
  if (!args.regions.empty()) return compare_with_regions(args, terminal);
  if (args.target.empty() || args.truth.empty()) {
    throw UsageError({.what = "nothing to compare the features with",
                      .remedy = "Give a second file of features with --truth, or --regions"});
  }
  const FeatureSet source = read_features(args.source), target = read_features(args.target);
  const Mesh mesh = mesh_for(args, target);
  const ConsistencyResult result = feature_consistency(source, target, read_surface_map(args.truth),
                                                       mesh, args.consistency, terminal.run);
  if (!args.curve.empty()) draw_curve(args.curve, result);
  const nlohmann::ordered_json json{{"source_features", result.source_count},
                                    {"target_features", result.target_count},
                                    {"unmapped", result.unmapped},
                                    {"features", json_of(result.features)},
                                    {"random_vertices", json_of(result.random)},
                                    {"shuffled_times", json_of(result.shuffled)}};
  const std::string text =
      std::to_string(result.source_count) + " and " + count_of(result.target_count, "feature") +
      "\n                  strict  slack   nearest" +
      row_of("features          ", result.features) + row_of("random vertices   ", result.random) +
      row_of("times shuffled    ", result.shuffled);
  terminal.print(terminal.json ? json.dump(2) : text);
  return ExitCode::done;
}

}  // namespace

CommandSpec evaluate_features_command() {
  return {.path = "evaluate features",
          .summary = "Compare features with those of another animation, or with marked regions",
          .example =
              "kinemesh evaluate features a.json b.json --truth a_to_b.csv --curve curve.png\n"
              "kinemesh evaluate features a.json --regions anna.json ben.ply",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positional("A", args->source, "Features of the source (JSON)");
            line.optional_positional("B", args->target, "Features of the target (JSON)");
            line.option("--truth", args->truth, "MAP",
                        "True map from the source's vertices to the target (surface map)");
            line.option("--mesh", args->mesh, "MESH",
                        "Mesh of the target (or of A with --regions), when its file has moved");
            line.option("--curve", args->curve, "PNG", "Draw the share of features by distance");
            line.words("--regions", args->regions, "FILE",
                       "Regions marked by hand, one file per volunteer: JSON lists of vertices or "
                       "coloured PLY");
            line.parameters([args](ParameterSet& p) {
              args->consistency.declare(p);
              args->read.declare(p);
            });
            line.json_output();
            return [args](Terminal& terminal) { return run_evaluate(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
