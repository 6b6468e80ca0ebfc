// kinemesh align: which instant of one performance is which of another, and how alike they are.
#include <algorithm>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "analysis/anim_dog.h"
#include "analysis/animation_similarity.h"
#include "analysis/descriptors.h"
#include "cli/commands/commands.h"
#include "config/output_file.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "report/chart.h"

namespace kinemesh::cli {
namespace {

struct Arguments {
  std::string animation_a, animation_b, output, picture;
  DeformationOptions deformation;
  DetectOptions detect;
  FeatureAlignmentOptions sequence;
  TimeWarpOptions warp;
  ReadOptions read;
};

/// What is compared of an animation.
struct Course {
  MotionCurves curves;
  FeatureSet features;
};

Course course_of(const std::string& path, const Arguments& args, const RunContext& ctx) {
  const AnimatedMesh animation =
      read_animation(builtin_mesh_formats(), path, args.read, ctx.part(0.0, 0.2, "reading"));
  const DeformationResult deformation =
      deformation_of(animation, args.deformation, ctx.part(0.2, 0.5, "deformation"));
  Course course{
      motion_signature(animation, deformation),
      detect_features(animation, deformation, args.detect, ctx.part(0.5, 0.9, "features")).set};
  describe_features(course.features, animation, deformation, {.histogram = false}, ctx);
  ctx.progress(1.0);
  return course;
}

std::string warp_csv(const TimeWarpResult& warp) {
  std::string csv = "a_s,b_s,moving\n";
  for (std::size_t f = 0; f < warp.b_of_a_s.size(); ++f) {
    csv += format_number(static_cast<double>(f) / warp.rate_hz) + "," +
           format_number(warp.b_of_a_s[f]) + "," + (warp.determined[f] != 0 ? "1" : "0") + "\n";
  }
  return csv;
}

/// A's curve of the strongest deformation, and B's before and after it is brought to A's time.
Canvas draw(const Course& a, const Course& b, const TimeWarpResult& warp) {
  const std::size_t strongest = a.curves.channel_count - 1;
  Series of_a{.label = "A", .colour = series_colour(0)};
  Series of_b{.label = "B, in A's time", .colour = series_colour(1)};
  Series delay{.label = "B − A", .colour = series_colour(2)};
  for (std::size_t f = 0; f < a.curves.frame_count; ++f) {
    const double time = static_cast<double>(f) / a.curves.rate_hz;
    const double in_b = std::clamp(warp.b_of_a_s[f], 0.0, b.curves.duration_s());
    const auto frame = static_cast<std::size_t>(in_b * b.curves.rate_hz + 0.5);
    of_a.x.push_back(time);
    of_a.y.push_back(a.curves.at(f, strongest));
    of_b.x.push_back(time);
    of_b.y.push_back(b.curves.at(std::min(frame, b.curves.frame_count - 1), strongest));
    delay.x.push_back(time);
    delay.y.push_back(warp.determined[f] != 0 ? 1e3 * (warp.b_of_a_s[f] - time)
                                              : std::numeric_limits<double>::quiet_NaN());
  }
  Canvas canvas(900, 520);
  LineChart{.title = "Strongest deformation (99 % of the surface deforms less)",
            .x = {.label = "time of A", .unit = "s"},
            .y = {.label = "deformation", .from_zero = true},
            .series = {of_a, of_b}}
      .draw(canvas, {20, 15, 860, 240});
  LineChart{.title = "How much later B does what A does, where something moves",
            .x = {.label = "time of A", .unit = "s"},
            .y = {.label = "delay", .unit = "ms", .from_zero = true},
            .series = {delay}}
      .draw(canvas, {20, 265, 860, 240});
  return canvas;
}

nlohmann::ordered_json json_of(const Arguments& args, const TimeWarpResult& warp,
                               const FeatureAlignment& features, const AnimationSimilarity& like) {
  nlohmann::ordered_json json{{"a", args.animation_a},
                              {"b", args.animation_b},
                              {"delay_s", warp.delay_s},
                              {"amplitude_b_over_a", warp.amplitude},
                              {"difference", warp.difference},
                              {"difference_unwarped", warp.difference_unwarped},
                              {"features",
                               {{"pairs", features.pairs.size()},
                                {"only_a", features.only_a.size()},
                                {"only_b", features.only_b.size()},
                                {"pair_cost", features.pair_cost},
                                {"gap_cost", features.gap_cost}}},
                              {"similarity",
                               {{"overall", like.overall},
                                {"features", like.features},
                                {"curves", like.curves},
                                {"timing", like.timing}}}};
  if (!args.output.empty()) json["output"] = args.output;
  return json;
}

std::string in_words(const TimeWarpResult& warp, const FeatureAlignment& features,
                     const AnimationSimilarity& like) {
  const auto percent = [](double part) { return format_fixed(100 * part, 0) + " %"; };
  return "delay       B does what A does " + format_fixed(1e3 * std::abs(warp.delay_s), 0) +
         " ms " + (warp.delay_s < 0 ? "earlier" : "later") + " (median where something moves)\n" +
         "amplitude   " + percent(warp.amplitude) + " of A's\n" + "features    " +
         count_of(features.pairs.size(), "pair") + " in the same order; " +
         std::to_string(features.only_a.size()) + " only in A, " +
         std::to_string(features.only_b.size()) + " only in B\n" + "similarity  " +
         percent(like.overall) + " (features " + percent(like.features) + ", curves " +
         percent(like.curves) + ", timing " + percent(like.timing) + ")";
}

ExitCode align(const Arguments& args, Terminal& terminal) {
  const Course a = course_of(args.animation_a, args, terminal.run.part(0.0, 0.45, "A"));
  const Course b = course_of(args.animation_b, args, terminal.run.part(0.45, 0.9, "B"));
  const TimeWarpResult warp =
      align_in_time(a.curves, b.curves, args.warp, terminal.run.part(0.9, 1.0, "alignment"));
  const FeatureAlignment features = align_features(a.features, b.features, args.sequence);
  const AnimationSimilarity like = similarity_of(features, warp);
  OutputSet files;
  if (!args.output.empty()) files.add(args.output, warp_csv(warp));
  if (!args.picture.empty()) {
    files.add(args.picture, encode_png(draw(a, b, warp).raster(2.0)));
  }
  files.commit();
  terminal.print(terminal.json ? json_of(args, warp, features, like).dump(2)
                               : in_words(warp, features, like));
  return ExitCode::done;
}

}  // namespace

CommandSpec align_command() {
  return {.path = "align",
          .summary = "Bring two performances into the same time, and say how alike they are",
          .example = "kinemesh align anna_happy.ply ben_happy.ply -o times.csv --picture times.png",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positional("ANIM_A", args->animation_a, "Animated mesh");
            line.positional("ANIM_B", args->animation_b, "Animated mesh that is compared with it");
            line.option("-o,--output", args->output, "OUT.csv",
                        "For each frame of A its time, the time of B, and whether something moves");
            line.option("--picture", args->picture, "OUT.png", "Curves and delay over time");
            line.parameters([args](ParameterSet& p) {
              args->warp.declare(p);
              args->sequence.declare(p);
              args->deformation.declare(p);
              args->detect.declare(p);
              args->read.declare(p);
            });
            line.json_output();
            return [args](Terminal& terminal) { return align(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
