// How far a way of driving the model faces is from the truth: one JSON object a line.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>

#include "tests/support/ict_expressions.h"

namespace kinemesh {

struct DriveWay {
  std::string name;
  std::function<AnimatedMesh(const test::IctExpressions&)> drive;
  uint64_t identities;  ///< of those asked for: slow ways, and those far behind, on a few only
};

/// Arguments of the programs: so many identities from the first one on.
struct IdentityRange {
  uint64_t count = 1, first = 0;
};
inline IdentityRange identity_range(int argc, char** argv, uint64_t count) {
  IdentityRange range{count, 0};
  if (argc > 1) range.count = std::strtoull(argv[1], nullptr, 10);
  if (argc > 2) range.first = std::strtoull(argv[2], nullptr, 10);
  return range;
}

/// All 57 expressions with every marker, and with 20 left out.
inline void print_accuracy(uint64_t identity, const DriveWay& way) {
  const auto ict = test::ict_expressions(identity);
  const auto left_out = test::draw_markers(20, ict.markers.size(), identity + 100);
  const AnimatedMesh driven = way.drive(ict);
  const auto all = test::drive_error(ict, driven);
  const auto near = test::drive_error(ict, driven, ict.near_markers);
  const auto out =
      test::place_error(ict, left_out, way.drive(test::without_markers(ict, left_out)));
  std::printf(
      "{\"identity\": %d, \"method\": \"%s\", \"markers\": %zu, \"mean\": %.4f, \"p95\": %.4f, "
      "\"near_mean\": %.4f, \"near_p95\": %.4f, \"left_out_mean\": %.4f, \"left_out_p95\": %.4f}\n",
      static_cast<int>(identity), way.name.c_str(), ict.markers.size(), all.mean, all.p95,
      near.mean, near.p95, out.mean, out.p95);
  std::fflush(stdout);
}

}  // namespace kinemesh
