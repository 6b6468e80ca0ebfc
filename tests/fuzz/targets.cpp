#include <algorithm>

#include "analysis/graph_matching/dd_file.h"
#include "capture/c3d/reader.h"
#include "capture/c3d/writer.h"
#include "tests/fuzz/mesh_targets.h"
#include "tests/fuzz/session_targets.h"
#include "tests/fuzz/target.h"
#include "tests/support/c3d_takes.h"

namespace kinemesh::fuzz {
namespace {

Outcome outcome_of(const C3dReadResult& r) {
  return r.findings.empty() ? Outcome::read : Outcome::read_with_findings;
}

std::vector<Seed> c3d_seeds() {
  MarkerSequence take = test::make_take(40, 9);
  test::add_analog(take, 3, 2);
  take.events = {{"Foot Strike", "Left", "A", 0.125}, {"Foot Off", "Right", "A", 0.25}};
  std::vector<Seed> seeds;
  for (const char* processor : {"intel", "dec", "sgi"}) {
    for (const char* storage : {"int", "float"}) {
      seeds.push_back({.name = std::string("made-") + processor + "-" + storage,
                       .bytes = encode_c3d(take, {.processor = processor, .storage = storage})});
    }
  }
  seeds.push_back({.name = "made-labels2", .bytes = encode_c3d(test::make_take(4, 300))});
  return seeds;
}

std::size_t c3d_payload(const std::string& bytes) {
  return read_c3d_head(std::as_bytes(std::span(bytes)), "seed").layout.data_begin;
}

Outcome read_c3d_bytes(std::span<const std::byte> bytes) {
  return outcome_of(read_c3d(bytes, "mutant.c3d"));
}

/// What was read can be written, whatever it was, and what was written is sound.
Outcome rewrite_c3d_bytes(std::span<const std::byte> bytes) {
  const C3dReadResult first = read_c3d(bytes, "mutant.c3d");
  const std::string written = encode_c3d(first.take);
  const C3dReadResult second = read_c3d(std::as_bytes(std::span(written)), "rewritten.c3d");
  if (has_errors(second.findings)) {
    const auto it = std::ranges::find(second.findings, Severity::error, &C3dFinding::severity);
    throw std::logic_error("rewriting gave " + it->code + ": " + it->message);
  }
  return outcome_of(first);
}

/// What is read is valid, and can be written and read back.
Outcome read_dd_bytes(std::span<const std::byte> bytes) {
  const MatchingProblem problem =
      parse_dd({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "mutant.dd");
  problem.validate();
  if (parse_dd(format_dd(problem), "again.dd").pairs.size() != problem.pairs.size()) {
    throw std::logic_error("a matching problem changed on its way through a file");
  }
  return Outcome::read;
}

std::vector<Seed> dd_seeds() {
  return {{.name = "made-dd",
           .bytes = "c made\np 2 2 3 1\na 0 0 0 -1.5\na 1 0 1 2e-1\na 2 1 1 -0.25\n"
                    "n0 0 1\ne 0 2 -1\n"}};
}

std::vector<Target> make_targets() {
  std::vector<Target> all = {
      {.name = "c3d",
       .extensions = {".c3d"},
       .run = read_c3d_bytes,
       .own_seeds = c3d_seeds,
       .payload = c3d_payload},
      {.name = "c3d-rewrite",
       .extensions = {".c3d"},
       .run = rewrite_c3d_bytes,
       .own_seeds = c3d_seeds,
       .payload = {},
       .max_seed_bytes = std::size_t{1} << 19},
      {.name = "dd",
       .extensions = {".dd"},
       .run = read_dd_bytes,
       .own_seeds = dd_seeds,
       .payload = {},
       .max_seed_bytes = std::size_t{1} << 17},
  };
  for (Target& target : session_targets(c3d_seeds)) all.push_back(std::move(target));
  for (Target& target : mesh_targets()) all.push_back(std::move(target));
  return all;
}

}  // namespace

const std::vector<Target>& targets() {
  static const std::vector<Target> all = make_targets();
  return all;
}

}  // namespace kinemesh::fuzz
