// kinemesh match: which feature of one animation is which of another.
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/feature_io.h"
#include "analysis/feature_matching.h"
#include "analysis/feature_matching_io.h"
#include "cli/commands/commands.h"
#include "config/output_file.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "report/match_view.h"

namespace kinemesh::cli {
namespace {

struct Arguments {
  std::string features_a, features_b, animation_a, animation_b, output, picture;
  FeatureMatchingOptions matching;
  MatchingOptions solver{.gap = 5e-4, .iterations = 60};
  ReadOptions read;
};

/// The animation named, or the one that the features name, beside their file or from here.
AnimatedMesh animation_of(const std::string& given, const std::string& features,
                          const FeatureSet& set, const ReadOptions& options,
                          const RunContext& ctx) {
  std::filesystem::path path = given;
  std::error_code ignored;
  if (path.empty()) {
    path = std::filesystem::path(features).parent_path() / set.animation;
    if (set.animation.empty() || !std::filesystem::exists(path, ignored)) path = set.animation;
    if (path.empty() || !std::filesystem::exists(path, ignored)) {
      throw UsageError({.what = "the animation of the features is not found",
                        .file = features,
                        .remedy = "Name both: kinemesh match FEATURES_A FEATURES_B ANIM_A ANIM_B"});
    }
  }
  AnimatedMesh animation = read_animation(builtin_mesh_formats(), path, options, ctx);
  if (animation.vertex_count() != set.vertex_count) {
    throw InputError({.what = "the features are of an animation with " +
                              std::to_string(set.vertex_count) + " vertices, this one has " +
                              std::to_string(animation.vertex_count()),
                      .file = path.string(),
                      .remedy = "Give the animation in which the features were found"});
  }
  return animation;
}

std::vector<Eigen::Vector3f> places(const std::vector<uint32_t>& features, const FeatureSet& set,
                                    const Mesh& mesh) {
  std::vector<Eigen::Vector3f> points;
  for (const uint32_t k : features) points.push_back(mesh.positions[set.features[k].vertex]);
  return points;
}

/// The picture as a file's bytes.
std::string draw(const Arguments& args, const FeatureMatching& matching, const FeatureSet& a,
                 const FeatureSet& b, const Mesh& mesh_a, const Mesh& mesh_b,
                 const RunContext& ctx) {
  std::vector<MatchLine> lines;
  for (const FeatureMatch& m : matching.matches) {
    lines.push_back({mesh_a.positions[a.features[m.source].vertex],
                     mesh_b.positions[b.features[m.target].vertex], std::to_string(m.source),
                     std::to_string(m.target)});
  }
  const auto name = [](const FeatureSet& set, const std::string& features) {
    return std::filesystem::path(set.animation.empty() ? features : set.animation).stem().string();
  };
  const MatchViewOptions view{
      .title = "Matches of " + std::filesystem::path(args.features_a).filename().string() +
               " and " + std::filesystem::path(args.features_b).filename().string(),
      .subtitle = count_of(matching.matches.size(), "match", "matches") +
                  " with the features' numbers; grey: features without a match; rings and dashes: "
                  "behind the surface",
      .source_name = name(a, args.features_a),
      .target_name = name(b, args.features_b)};
  const Canvas canvas =
      draw_matches(mesh_a, mesh_b, lines, places(matching.unmatched_source, a, mesh_a),
                   places(matching.unmatched_target, b, mesh_b), view, ctx);
  return lower(std::filesystem::path(args.picture).extension().string()) == ".svg"
             ? canvas.svg_file({.title = view.title})
             : canvas.png_file();
}

std::string in_words(const FeatureMatching& matching) {
  const auto number = [](double value) {
    return format_fixed(std::abs(value) < 5e-5 ? 0.0 : value, 4);  // no minus nought
  };
  std::string text = count_of(matching.matches.size(), "match", "matches") + ", " +
                     std::to_string(matching.unmatched_source.size()) + " and " +
                     std::to_string(matching.unmatched_target.size()) +
                     " features without one; energy " + number(matching.solution.energy) +
                     ", bound " + number(matching.solution.bound) +
                     (matching.solution.certified ? " (certified)" : " (not certified)");
  if (!matching.rejected.empty()) {
    text += "\n" + count_of(matching.rejected.size(), "match", "matches") +
            " taken back: not where the others put them (--reject)";
  }
  if (!matching.empty_reason.empty()) text += "\nno match: " + matching.empty_reason;
  return text;
}

void refuse_picture(const std::string& picture) {
  const std::string extension = lower(std::filesystem::path(picture).extension().string());
  if (picture.empty() || extension == ".png" || extension == ".svg") return;
  throw UsageError({.what = "pictures of matches are .png or .svg, not '" + extension + "'",
                    .file = picture,
                    .remedy = "Name the picture matches.png or matches.svg"});
}

ExitCode run_match(const Arguments& args, Terminal& terminal) {
  check_matches_path(args.output);
  refuse_picture(args.picture);
  refuse_to_replace({args.features_a, args.features_b, args.animation_a, args.animation_b},
                    {args.output, args.picture});
  const FeatureSet a = read_features(args.features_a), b = read_features(args.features_b);
  refuse_too_many_features(a.features.size(), b.features.size(), args.matching);
  const AnimatedMesh mesh_a =
      animation_of(args.animation_a, args.features_a, a, args.read, terminal.run);
  const AnimatedMesh mesh_b =
      animation_of(args.animation_b, args.features_b, b, args.read, terminal.run);
  const FeaturePlaces places_a = feature_places(a, mesh_a, args.matching, terminal.run);
  const FeaturePlaces places_b = feature_places(b, mesh_b, args.matching, terminal.run);
  const FeatureMatching matching =
      match_features(places_a, places_b, args.matching, args.solver, terminal.run);
  OutputSet files;
  files.add(args.output, matches_text(args.output, matching, a, b));
  if (!args.picture.empty()) {
    files.add(args.picture,
              draw(args, matching, a, b, mesh_a.mesh_at(0), mesh_b.mesh_at(0), terminal.run));
  }
  files.commit();
  terminal.print(terminal.json ? matches_json(matching, a, b) : in_words(matching));
  return ExitCode::done;
}

}  // namespace

CommandSpec match_command() {
  return {.path = "match",
          .summary = "Match the features of two animations",
          .example =
              "kinemesh match a.features.json b.features.json a.ply b.ply -o matches.json\n"
              "kinemesh match a.json b.json a.ply b.ply -o matches.csv --picture matches.png",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positional("FEATURES_A", args->features_a, "Features of the source (JSON)");
            line.positional("FEATURES_B", args->features_b, "Features of the target (JSON)");
            line.optional_positional("ANIM_A", args->animation_a,
                                     "The source's animation; else the one its features name");
            line.optional_positional("ANIM_B", args->animation_b, "The target's animation");
            line.option("-o,--output", args->output, "OUT", "OUT.json or OUT.csv", true);
            line.option("--picture", args->picture, "FILE",
                        "A picture of both meshes with a line for each match (.png or .svg)");
            line.parameters([args](ParameterSet& p) {
              args->matching.declare(p);
              args->solver.declare(p);
              args->read.declare(p);
            });
            line.json_output();
            return [args](Terminal& terminal) { return run_match(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
