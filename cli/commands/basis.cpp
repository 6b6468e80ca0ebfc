// kinemesh basis and kinemesh express: performances as curves of principal shapes.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/formats/mesh_formats.h"
#include "cli/commands/commands.h"
#include "config/output_file.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/pca/expression_basis.h"

namespace kinemesh::cli {
namespace {

struct BasisState {
  std::vector<std::string> animations;
  std::string output;
  ReadOptions reading;
  PcaOptions pca{.rms_error_mm = 0.1};
};

ExitCode make_basis(BasisState& state, Terminal& terminal) {
  const FormatRegistry formats = all_formats();
  refuse_to_replace({state.animations.begin(), state.animations.end()}, {state.output});
  std::vector<AnimatedMesh> animations;
  for (const std::string& path : state.animations) {
    animations.push_back(
        read_animation(formats, path, state.reading, terminal.run.part(0.0, 0.4, "reading")));
  }
  ExpressionBasis basis =
      make_expression_basis(animations, state.pca, terminal.run.part(0.4, 1.0, "principal shapes"));
  for (const std::string& path : state.animations) {
    basis.sources.push_back(std::filesystem::path(path).filename().string());
  }
  write_expression_basis(state.output, basis);
  const PcaResult& pca = basis.pca;
  const std::size_t modes = pca.mode_count();
  if (terminal.json) {
    nlohmann::ordered_json json{{"frames", pca.scores.rows()},
                                {"vertices", pca.vertex_count},
                                {"modes", modes},
                                {"explained", pca.explained(modes)},
                                {"rms_error_mm", pca.rms_error_mm(modes)},
                                {"output", state.output}};
    for (std::size_t k = 1; k <= modes; ++k) json["explained_by"].push_back(pca.explained(k));
    terminal.print(json.dump(2));
  } else if (!terminal.quiet) {
    terminal.print("modes       " + std::to_string(modes) + ", explaining " +
                   format_fixed(100.0 * pca.explained(modes), 2) + " % of the motion to " +
                   format_fixed(pca.rms_error_mm(modes), 3) + " mm (root mean square)");
    for (std::size_t k = 1; k <= std::min<std::size_t>(modes, 8); ++k) {
      terminal.print("  mode " + std::to_string(k) + "    " +
                     format_fixed(100.0 * pca.explained(k), 2) + " % so far");
    }
    terminal.print("written     " + state.output);
  }
  return ExitCode::done;
}

struct ExpressState {
  std::string basis, animation, output;
  ReadOptions reading;
};

ExitCode express_animation(ExpressState& state, Terminal& terminal) {
  if (state.output.empty()) {
    state.output = std::filesystem::path(state.animation).stem().string() + "_scores.csv";
  }
  refuse_to_replace({state.basis, state.animation}, {state.output});
  const ExpressionBasis basis = read_expression_basis(state.basis);
  const AnimatedMesh animation = read_animation(all_formats(), state.animation, state.reading,
                                                terminal.run.part(0.0, 0.5, "reading"));
  const ExpressionScores scores =
      express(basis, animation, terminal.run.part(0.5, 1.0, "expressing"));
  write_file(state.output, scores_csv(scores, animation.rate_hz, animation.first_frame));
  const double rms =
      std::sqrt(scores.rms_error_mm.squaredNorm() /
                static_cast<double>(std::max<Eigen::Index>(1, scores.scores.rows())));
  if (terminal.json) {
    terminal.print(nlohmann::ordered_json{
        {"frames", scores.scores.rows()},
        {"modes", scores.scores.cols()},
        {"explained", scores.explained},
        {"rms_error_mm", rms},
        {"output",
         state.output}}.dump(2));
  } else if (!terminal.quiet) {
    terminal.print("expressed   " +
                   count_of(static_cast<std::size_t>(scores.scores.rows()), "frame") + " in " +
                   count_of(basis.pca.mode_count(), "mode") + ", root mean square error " +
                   format_fixed(rms, 3) + " mm");
    terminal.print("written     " + state.output);
  }
  return ExitCode::done;
}

}  // namespace

CommandSpec basis_command() {
  return {.path = "basis",
          .summary = "Find the principal shapes of animations of one mesh",
          .example = "kinemesh basis anna_happy.ply anna_surprise.ply -o anna_basis.npz",
          .setup = [](CommandLine& line) -> Action {
            auto state = std::make_shared<BasisState>();
            line.positionals("ANIM", state->animations, "Animations of one mesh");
            line.option("-o,--output", state->output, "BASIS",
                        "NumPy archive: mean, modes, variances, scores of every frame", true);
            line.parameters([state](ParameterSet& p) {
              state->reading.declare(p);
              state->pca.declare(p);
            });
            line.json_output();
            return [state](Terminal& terminal) { return make_basis(*state, terminal); };
          }};
}

CommandSpec express_command() {
  return {.path = "express",
          .summary = "Describe an animation by its scores in a basis",
          .example = "kinemesh express anna_basis.npz anna_talk.ply -o anna_talk_scores.csv",
          .setup = [](CommandLine& line) -> Action {
            auto state = std::make_shared<ExpressState>();
            line.positional("BASIS", state->basis, "What kinemesh basis wrote");
            line.positional("ANIM", state->animation, "An animation of the same mesh");
            line.option("-o,--output", state->output, "OUT",
                        "CSV of the scores, a line a frame; by default the animation's name with "
                        "_scores.csv, in the current folder");
            line.parameters([state](ParameterSet& p) { state->reading.declare(p); });
            line.json_output();
            return [state](Terminal& terminal) { return express_animation(*state, terminal); };
          }};
}

}  // namespace kinemesh::cli
