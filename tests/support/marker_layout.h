// Where the markers of a synthetic subject sit: points of the surface, never at its vertices.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/synthetic_face.h"

namespace kinemesh::test {

struct LayoutOptions {
  double spacing_mm = 9;  ///< distance to the nearest marker: at least 0.89 of it
  uint64_t seed = 1;
  bool rings = true;  ///< rows of markers around mouth and eyes, as labs place them
  /// Half width of the marked region in the domain: 68 is the front of the face (about 160
  /// markers 9 mm apart), 95 reaches the ears.
  double sideways = 68;
  double top = 54, bottom = -72;  ///< of the marked region in the domain
};

struct MarkerLayout {
  std::vector<SurfacePoint> points;
  std::vector<Eigen::Vector2d> domain;  ///< per marker, see synthetic_face.h
  std::vector<std::string> labels;      ///< region, side and number: "LCHK04"
  std::size_t size() const { return points.size(); }
};

MarkerLayout place_markers(const SyntheticFace& face, const LayoutOptions& options = {});
/// As above with about this spacing and seed.
MarkerLayout place_markers(const SyntheticFace& face, double spacing_mm, uint64_t seed);

struct TransferOptions {
  double jitter_mm = 1;     ///< standard deviation in each direction of the domain
  std::size_t missing = 0;  ///< so many markers of the first subject are left out
  double least_mm = 0;      ///< markers that end up closer than this are moved apart
  uint64_t seed = 1;
};

/// The same marker set on another subject, placed by hand: not exactly, and some left out.
MarkerLayout transfer_markers(const MarkerLayout& layout, const SyntheticFace& target,
                              const TransferOptions& options = {});
/// Pairs of marker indices (first, second) that carry the same label.
std::vector<std::pair<std::size_t, std::size_t>> correspondence_of(const MarkerLayout& first,
                                                                   const MarkerLayout& second);

}  // namespace kinemesh::test
