// kinemesh correspond: where every vertex of one animated surface lies on another.
#include <nlohmann/json.hpp>

#include "analysis/full_matching/full_matching.h"
#include "cli/commands/commands.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/surface_map_io.h"

namespace kinemesh::cli {
namespace {

struct Arguments {
  std::string source, target, output, reverse, landmarks;
  FullMatchingOptions matching;
  ReadOptions read;
};

std::string share_of(std::size_t part, std::size_t all) {
  return format_fixed(100.0 * static_cast<double>(part) / static_cast<double>(all), 1) + " %";
}

std::string in_words(const Arguments& args, const FullMatching& m) {
  std::string text;
  if (m.poor) text += "POOR MAP: " + m.warning + "\n";
  const std::size_t n = m.forward.points.size(), back = m.reverse.points.size();
  text += m.forward.source_name + " → " + m.forward.target_name + ": " +
          count_of(n - m.unmapped_source, "vertex", "vertices") + " of " + std::to_string(n) +
          " mapped; " + share_of(m.snapped_source, n) + " lie on the edge of a hole, " +
          share_of(m.unmapped_source, n) + " fall into one\n";
  if (!args.reverse.empty()) {
    text += m.reverse.source_name + " → " + m.reverse.target_name + ": " +
            count_of(back - m.unmapped_target, "vertex", "vertices") + " of " +
            std::to_string(back) + " mapped\n";
  }
  text += "distortion " + format_fixed(m.mean_distortion, 3) + " (1: none); agreement with " +
          "chance as 0: strain " + format_fixed(m.agreement.strain, 2) + ", normals " +
          format_fixed(m.agreement.normals, 2) + ", loops " + format_fixed(m.agreement.loops, 2);
  return text;
}

nlohmann::json as_json(const ThereAndBack& t) {
  return {{"mean", t.mean}, {"worst", t.worst}, {"points", t.points}};
}

nlohmann::json as_json(const FullMatching& m) {
  return {{"source", m.forward.source_name},
          {"target", m.forward.target_name},
          {"poor", m.poor},
          {"warning", m.warning},
          {"vertices", m.forward.points.size()},
          {"unmapped_source", m.unmapped_source},
          {"unmapped_target", m.unmapped_target},
          {"on_loops_source", m.snapped_source},
          {"on_loops_target", m.snapped_target},
          {"distortion", m.mean_distortion},
          {"there_and_back",
           {{"exactly", as_json(m.exactly)}, {"by_vertices", as_json(m.by_vertices)}}},
          {"agreement",
           {{"strain", m.agreement.strain},
            {"normals", m.agreement.normals},
            {"loops", m.agreement.loops}}}};
}

AnimatedMesh read(const std::string& path, const ReadOptions& options, const RunContext& ctx) {
  return read_animation(builtin_mesh_formats(), path, options, ctx);
}

ExitCode run_correspond(const Arguments& args, Terminal& terminal) {
  const AnimatedMesh a = read(args.source, args.read, terminal.run);
  const AnimatedMesh b = read(args.target, args.read, terminal.run);
  std::vector<LandmarkPair> landmarks;
  if (!args.landmarks.empty()) {
    landmarks = read_landmark_pairs(args.landmarks, a.topology(), b.topology());
  }
  FullMatching m = match_surfaces(a, b, args.matching, terminal.run, landmarks);
  m.forward.source_name = m.reverse.target_name = args.source;
  m.forward.target_name = m.reverse.source_name = args.target;
  if (m.poor) terminal.run.warn(m.warning);
  write_surface_map(args.output, m.forward);
  if (!args.reverse.empty()) write_surface_map(args.reverse, m.reverse);
  terminal.print(terminal.json ? as_json(m).dump(2) : in_words(args, m));
  return ExitCode::done;
}

}  // namespace

CommandSpec correspond_command() {
  return {.path = "correspond",
          .summary = "Map every vertex of one animated surface onto another, one-to-one",
          .example =
              "kinemesh correspond anna.ply ben.ply -o anna_to_ben.csv\n"
              "kinemesh correspond a.npz b.npz -o a_to_b.npz --reverse b_to_a.npz\n"
              "kinemesh correspond cat.off lion.off -o map.csv --landmarks pairs.txt",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positional("A", args->source, "The source's animation");
            line.positional("B", args->target, "The target's animation");
            line.option("-o,--output", args->output, "MAP",
                        "Map A → B: .csv, .json or .npz (a point of B for each vertex of A)", true);
            line.option("--reverse", args->reverse, "MAP", "Map B → A, too");
            line.option("--landmarks", args->landmarks, "FILE",
                        "Pairs that the map meets exactly, one a line: a vertex of A and a vertex "
                        "of B, counted from 0 (or a point of B as FACE:B0:B1:B2)");
            line.parameters([args](ParameterSet& p) {
              args->matching.declare(p);
              args->read.declare(p);
            });
            line.json_output();
            return [args](Terminal& terminal) { return run_correspond(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
