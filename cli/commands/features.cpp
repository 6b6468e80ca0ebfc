// kinemesh features: dynamic features of an animated mesh.
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "analysis/anim_dog.h"
#include "analysis/descriptors.h"
#include "analysis/feature_io.h"
#include "analysis/feature_view.h"
#include "analysis/jumps.h"
#include "cli/commands/commands.h"
#include "config/error.h"
#include "config/output_file.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "report/gap_chart.h"

namespace kinemesh::cli {
namespace {

namespace fs = std::filesystem;

enum class Preset : uint8_t { best, thesis };

struct Arguments {
  std::string animation, output;
  bool csv = false, picture = false, video = false, displacement = true;
  Preset preset = Preset::best;
  DeformationOptions deformation;
  DetectOptions detect;
  DisplacementOptions displaced;
  DescriptorOptions descriptors;
  ReadOptions read;

  void declare(ParameterSet& p) {
    p.group("preset", "Settings");
    p.choice("preset", preset,
             {{Preset::best, "best", "what measures best"},
              {Preset::thesis, "thesis", "as printed in Mykhalchuk's thesis"}},
             "What the other settings start from");
    deformation.declare(p);
    detect.declare(p);
    displaced.declare(p);
    p.flag("displacement-features", displacement, "Find displacement features, too");
    descriptors.declare(p);
    read.declare(p);
  }
};

/// The preset's values for what was not set to something else than the default.
template <class Options>
void take_over(Options& options, Options preset) {
  Options defaults;
  ParameterSet own, base, wanted;
  options.declare(own);
  defaults.declare(base);
  preset.declare(wanted);
  for (Parameter& p : own.parameters()) {
    if (p.get() == base.find(p.name())->get()) p.set(wanted.find(p.name())->get());
  }
}

void apply_preset(Arguments& args) {
  if (args.preset != Preset::thesis) return;
  DeformationOptions deformation;
  DetectOptions detect;
  set_thesis_preset(deformation, detect);
  take_over(args.deformation, deformation);
  take_over(args.detect, detect);
}

bool run_ffmpeg(const fs::path& frames, double rate, const fs::path& video) {
  std::vector<std::string> words{"ffmpeg",      "-y",
                                 "-loglevel",   "error",
                                 "-framerate",  format_number(rate),
                                 "-i",          (frames / "frame_%04d.png").string(),
                                 "-pix_fmt",    "yuv420p",
                                 video.string()};
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  if (::posix_spawnp(&child, "ffmpeg", nullptr, nullptr, argv.data(), environ) != 0) return false;
  int status = 0;
  return ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// OUT.mp4 where ffmpeg is installed; otherwise the frames in OUT_video/.
std::string write_video(const AnimatedMesh& animation, const DeformationResult& deformation,
                        const FeatureSet& set, const fs::path& stem, const RunContext& ctx) {
  const fs::path folder = stem.string() + "_video";
  OutputSet files;
  files.create_folder(folder);
  for (std::size_t f = 0; f < animation.frame_count(); ++f) {
    ctx.progress(static_cast<double>(f) / static_cast<double>(animation.frame_count()));
    std::string number = std::to_string(f);
    number.insert(0, number.size() < 4 ? 4 - number.size() : 0, '0');
    files.add(folder / ("frame_" + number + ".png"),
              encode_png(draw_feature_frame(animation, deformation, set, f, ctx)));
  }
  files.commit();
  const fs::path video = stem.string() + ".mp4";
  const double rate = animation.rate_hz > 0 ? animation.rate_hz : 25.0;
  if (!run_ffmpeg(folder, rate, video)) {
    ctx.info("ffmpeg is not installed or failed: the video is left as PNG frames");
    return folder.string();
  }
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  return video.string();
}

void check_output(const fs::path& output) {
  if (lower(output.extension().string()) == ".json") return;
  throw UsageError({.what = "features are written as JSON, not as '" + output.string() + "'",
                    .remedy = "Give an output that ends in .json; --csv writes a table beside it"});
}

ExitCode run_features(Arguments& args, Terminal& terminal) {
  check_output(args.output);
  apply_preset(args);
  const AnimatedMesh animation = read_animation(builtin_mesh_formats(), args.animation, args.read,
                                                terminal.run.part(0.0, 0.1, "reading"));
  warn_of_jumps(animation, terminal.run);
  const DeformationResult deformation =
      deformation_of(animation, args.deformation, terminal.run.part(0.1, 0.3, "deformation"));
  DetectResult result =
      detect_features(animation, deformation, args.detect, terminal.run.part(0.3, 0.7, "features"));
  result.set.animation = args.animation;
  const std::size_t deforming = result.set.features.size();
  if (args.displacement) {
    for (Feature& f : displacement_features(animation, deformation, args.displaced)) {
      result.set.features.push_back(std::move(f));
    }
  }
  describe_features(result.set, animation, deformation, args.descriptors,
                    terminal.run.part(0.7, 0.8, "descriptors"));
  const fs::path output = args.output;
  const fs::path stem = output.parent_path() / output.stem();
  OutputSet files;
  files.add(output, features_json(result.set));
  if (args.csv) files.add(stem.string() + ".csv", features_csv(result.set));
  if (args.picture) {
    FeatureViewOptions view;
    view.title = "Features of " + fs::path(args.animation).filename().string();
    const Canvas canvas = draw_features(animation, deformation, result.set, view, terminal.run);
    files.add(stem.string() + ".png", encode_png(canvas.raster(png_scale(canvas))));
  }
  std::vector<std::string> written;
  for (const auto& path : files.paths()) written.push_back(path.string());
  files.commit();
  if (args.video) {
    written.push_back(write_video(animation, deformation, result.set, stem,
                                  terminal.run.part(0.8, 1.0, "drawing")));
  }
  const nlohmann::ordered_json json{
      {"animation", args.animation},
      {"features", deforming},
      {"displacement_features", result.set.features.size() - deforming},
      {"extrema", result.extrema},
      {"sigmas_mm", result.sigmas_mm},
      {"taus_s", result.taus_s},
      {"degenerate_faces", deformation.degenerate_faces},
      {"empty_reason", result.empty_reason},
      {"files", written}};
  std::string text = count_of(deforming, "deformation feature") + " of " +
                     count_of(result.extrema, "extremum", "extrema") + ", " +
                     count_of(result.set.features.size() - deforming, "displacement feature");
  if (!result.empty_reason.empty()) text += "\nno deformation features: " + result.empty_reason;
  if (deformation.degenerate_faces > 0) {
    text += "\n" + count_of(deformation.degenerate_faces, "triangle") + " without area left out";
  }
  terminal.print(terminal.json ? json.dump(2)
                               : text + "\nwritten     " + join(written, "\n            "));
  return ExitCode::done;
}

}  // namespace

CommandSpec features_command() {
  return {.path = "features",
          .summary = "Find the places and moments at which a surface deforms distinctly",
          .example =
              "kinemesh features face.ply -o features.json --picture\n"
              "kinemesh features horse.ply --preset thesis -o features.json --csv",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positional("ANIM", args->animation, "Animated mesh");
            line.option("-o,--output", args->output, "OUT.json", "Features with their descriptors",
                        true);
            line.flag("--csv", args->csv, "Also write OUT.csv, without descriptors");
            line.flag("--picture", args->picture, "Also draw OUT.png");
            line.flag("--video", args->video,
                      "Also make OUT.mp4 (ffmpeg), or PNG frames in OUT_video");
            line.parameters([args](ParameterSet& p) { args->declare(p); });
            line.json_output();
            return [args](Terminal& terminal) { return run_features(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
