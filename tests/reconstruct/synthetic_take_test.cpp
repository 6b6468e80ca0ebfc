#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "tests/support/samples.h"
#include "tests/support/synthetic_take.h"
#include "tests/support/triangulation_score.h"

namespace kinemesh::test::synthetic_take_test {
namespace {

SyntheticTake short_take(TakeOptions options = {}) {
  const auto face = make_face({.seed = 2});
  options.duration_s = 1.5;
  return make_take(face, place_markers(*face, 14, 1), make_motion(MotionKind::surprise), options);
}

TEST(SyntheticTake, NoiseHasItsStandardDeviation) {
  const SyntheticTake take = short_take({.noise_mm = 0.2});
  double squares = 0, sum = 0;
  const std::size_t values = take.truth.positions().size();
  for (std::size_t k = 0; k < values; ++k) {
    const double error = take.measured.positions()[k] - take.truth.positions()[k];
    squares += error * error;
    sum += error;
  }
  const double n = static_cast<double>(values);
  EXPECT_NEAR(std::sqrt(squares / n), 0.2, 0.2 * 4 / std::sqrt(2 * n));
  EXPECT_NEAR(sum / n, 0, 0.2 * 4 / std::sqrt(n));
}

TEST(SyntheticTake, HeadPoseTakesTheFaceToTheLab) {
  const SyntheticTake take =
      short_take({.noise_mm = 0, .head_degrees = 10, .head_mm = 40, .head_rig = true});
  ASSERT_EQ(take.measured.marker_count(), take.face_marker_count() + 6);
  double turned = 0, moved = 0;
  for (std::size_t f = 0; f < take.truth.frame_count(); f += 7) {
    const Eigen::Isometry3d& pose = take.head_pose[f];
    EXPECT_NEAR(pose.linear().determinant(), 1, 1e-12);
    for (std::size_t m = 0; m < take.face_marker_count(); ++m) {
      const Eigen::Vector3d expected =
          pose * take.face->point(take.layout.points[m], take.weights[f]);
      EXPECT_LT((take.truth.position(f, m).cast<double>() - expected).norm(), 1e-3);
    }
    // The rig is rigid: in the head's frame it never moves.
    for (std::size_t m = take.face_marker_count(); m < take.truth.marker_count(); ++m) {
      const Eigen::Vector3d now = pose.inverse() * take.truth.position(f, m).cast<double>();
      const Eigen::Vector3d first =
          take.head_pose[0].inverse() * take.truth.position(0, m).cast<double>();
      EXPECT_LT((now - first).norm(), 1e-3);
    }
    const Eigen::AngleAxisd turn(pose.linear() * take.head_pose[0].linear().transpose());
    turned = std::max(turned, std::abs(turn.angle()) * 180 / 3.14159265);
    moved = std::max(moved, (pose.translation() - take.head_pose[0].translation()).norm());
  }
  EXPECT_GT(turned, 2);
  EXPECT_LT(turned, 45);
  EXPECT_GT(moved, 8);
}

TEST(SyntheticTake, TheSurfaceOfAFrameCarriesTheMarkers) {
  const SyntheticTake take = short_take({.head_degrees = 5});
  const TrueSurface surface = take.surface_at(100);
  for (std::size_t m = 0; m < take.face_marker_count(); ++m) {
    const auto p = position_of(take.layout.points[m], *surface.topology, surface.positions);
    EXPECT_LT((p - take.truth.position(100, m).cast<double>()).norm(), 1e-3);
  }
}

TEST(SyntheticTake, GapsAreWhatTheListSays) {
  const SyntheticTake take = short_take({.short_gaps = 30, .long_gaps = 3, .head_rig = true});
  EXPECT_GE(take.gaps.size(), 20U);
  std::vector<bool> missing(take.measured.sample_count(), false);
  std::size_t longest = 0;
  for (const GapRecord& gap : take.gaps) {
    ASSERT_LE(gap.first_frame, gap.last_frame);
    ASSERT_LT(gap.last_frame, take.measured.frame_count());
    longest = std::max(longest, gap.last_frame - gap.first_frame + 1);
    for (std::size_t f = gap.first_frame; f <= gap.last_frame; ++f) {
      missing[take.measured.sample(f, gap.marker)] = true;
    }
  }
  EXPECT_GE(longest, 36U);   // 0.3 s
  EXPECT_LE(longest, 120U);  // 1 s
  for (std::size_t f = 0; f < take.measured.frame_count(); ++f) {
    for (std::size_t m = 0; m < take.measured.marker_count(); ++m) {
      EXPECT_EQ(take.measured.valid(f, m), !missing[take.measured.sample(f, m)]);
      EXPECT_TRUE(take.truth.valid(f, m));
    }
  }
}

TEST(SyntheticTake, ALabelSwapExchangesTwoNeighbours) {
  const SyntheticTake take = short_take({.noise_mm = 0, .label_swap = true});
  ASSERT_TRUE(take.swap.has_value());
  const SwapRecord swap = *take.swap;
  for (std::size_t f = 0; f < take.measured.frame_count(); ++f) {
    for (std::size_t m = 0; m < take.measured.marker_count(); ++m) {
      std::size_t from = m;
      if (f >= swap.from_frame && m == swap.first) from = swap.second;
      if (f >= swap.from_frame && m == swap.second) from = swap.first;
      EXPECT_EQ(Eigen::Vector3f(take.measured.position(f, m)),
                Eigen::Vector3f(take.truth.position(f, from)));
    }
  }
  EXPECT_LT((take.truth.position(0, swap.first) - take.truth.position(0, swap.second)).norm(), 25);
}

TEST(SyntheticTake, TheSameSeedGivesTheSameTake) {
  TakeOptions options{.short_gaps = 10, .long_gaps = 1, .head_degrees = 5, .label_swap = true};
  const auto bytes = [](const SyntheticTake& take) {
    const auto p = take.measured.positions();
    return std::string(reinterpret_cast<const char*>(p.data()), p.size_bytes());
  };
  const std::string first = bytes(short_take(options));
  EXPECT_EQ(first, bytes(short_take(options)));
  options.seed = 2;
  EXPECT_NE(first, bytes(short_take(options)));
}

TEST(SyntheticTake, MotionsOpenWhatTheySay) {
  const auto face = make_face({.seed = 0});
  using enum MotionKind;
  for (const MotionKind kind :
       {happy, surprise, jaw, brows, blinks, pucker, pucker_jaw, talk, puff}) {
    const Motion motion = make_motion(kind);
    for (const Slit& slit : face->rest().slits) {
      double least = 1e9, most = 0;
      for (double t = 0; t < 3.5; t += 1 / 120.0) {
        const ExpressionWeights w = motion.at(t);
        double widest = 0;
        for (std::size_t k = 0; k < slit.upper.size(); k += 3) {
          widest = std::max(
              widest, (face->vertex(slit.upper[k], w) - face->vertex(slit.lower[k], w)).norm());
        }
        least = std::min(least, widest);
        most = std::max(most, widest);
      }
      const bool opens = std::count(motion.openings.begin(), motion.openings.end(), slit.name) > 0;
      if (opens) {
        EXPECT_GT(most - least, 6) << motion.name << " " << slit.name;
      } else {
        EXPECT_LT(most - least, 1.5) << motion.name << " " << slit.name;
      }
    }
  }
}

TEST(SyntheticTake, PulsesStartAndPeakWhenTheySay) {
  const Motion motion = make_motion(MotionKind::happy);
  EXPECT_EQ(motion.at(motion.onset_s)[Expression::smile_left], 0);
  EXPECT_GT(motion.at(motion.onset_s + 0.1)[Expression::smile_left], 0);
  EXPECT_DOUBLE_EQ(motion.at(motion.peak_s)[Expression::smile_left], 1);
  const Motion other = vary(motion, 3);
  EXPECT_EQ(other.at(other.onset_s)[Expression::smile_left], 0);
  EXPECT_NE(other.onset_s, motion.onset_s);
  EXPECT_EQ(other.openings, motion.openings);
}

/// The reference scores itself perfectly; without its openings it is told so; the triangulation of
/// another frame differs a little.
TEST(SyntheticTake, ScoreTellsGoodFromBad) {
  const auto face = make_face({.seed = 3});
  const SyntheticTake take = make_take(face, place_markers(*face, 11, 3),
                                       make_motion(MotionKind::surprise), {.duration_s = 1.6});
  const GeodesicDelaunay reference = take.reference_at(0);
  const Topology same(reference.sites.size(), reference.triangles);
  const TriangulationScore best = score_triangulation(same, reference);
  EXPECT_EQ(best.precision, 1);
  EXPECT_EQ(best.recall, 1);
  EXPECT_EQ(best.rms_ratio, 1);
  EXPECT_TRUE(best.openings_right && best.manifold && best.all_markers && best.outwards);
  EXPECT_EQ(best.euler, 1 - 3);
  EXPECT_EQ(best.edges_across, 0U);
  for (const OpeningScore& o : best.openings) EXPECT_EQ(o.differing_triangles, 0U);
  EXPECT_LT(best.reference_rms_mm, 1.2);
  EXPECT_GT(best.reference_rms_mm, 0.3);

  const auto closed = geodesic_delaunay(take.surface_at(0), take.layout.points, {});
  const TriangulationScore shut =
      score_triangulation(Topology(closed.sites.size(), closed.triangles), reference);
  EXPECT_FALSE(shut.openings_right);
  EXPECT_GE(shut.edges_across, 10U);
  EXPECT_GE(shut.openings[0].differing_triangles, 8U);
  EXPECT_LT(shut.precision, 0.97);

  std::vector<Triangle> turned = reference.triangles, holed = reference.triangles;
  for (Triangle& t : turned) std::swap(t[0], t[1]);
  EXPECT_FALSE(score_triangulation(Topology(reference.sites.size(), turned), reference).outwards);
  const auto inner = std::find_if(holed.begin(), holed.end(), [&](const Triangle& t) {
    return std::none_of(t.begin(), t.end(), [&](uint32_t v) { return same.is_boundary_vertex(v); });
  });
  holed.erase(inner);
  EXPECT_EQ(score_triangulation(Topology(reference.sites.size(), holed), reference).false_openings,
            1U);
}

TEST(SyntheticTake, SamplesAreWhatTheReadmeSays) {
  for (const std::string& name : sample_names()) {
    const SyntheticTake take = make_sample(name);
    EXPECT_NEAR(static_cast<double>(take.face_marker_count()), 160, 8) << name;
    EXPECT_EQ(take.measured.marker_count(), take.face_marker_count() + 6) << name;
    EXPECT_EQ(take.measured.rate_hz, 120) << name;
    EXPECT_EQ(take.swap.has_value(), name == sample_with_swap) << name;
    EXPECT_EQ(take.motion.openings.size(), 3U) << name;
    EXPECT_GE(take.gaps.size(), 40U) << name;
    std::map<std::string, int> labels;
    for (const Marker& m : take.measured.markers()) EXPECT_EQ(++labels[m.label], 1) << m.label;
    std::vector<double> nearest;
    for (std::size_t i = 0; i < take.face_marker_count(); ++i) {
      double least = 1e9;
      for (std::size_t j = 0; j < take.face_marker_count(); ++j) {
        if (j != i) {
          least = std::min<double>(least,
                                   (take.truth.position(0, i) - take.truth.position(0, j)).norm());
        }
      }
      nearest.push_back(least);
    }
    std::sort(nearest.begin(), nearest.end());
    EXPECT_GT(nearest.front(), 7.9) << name;
    EXPECT_LT(nearest[nearest.size() * 9 / 10], 10.6) << name;
  }
}

}  // namespace
}  // namespace kinemesh::test::synthetic_take_test
