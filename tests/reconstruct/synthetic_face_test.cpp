#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "config/error.h"
#include "tests/support/marker_layout.h"
#include "tests/support/synthetic_body.h"
#include "tests/support/synthetic_face.h"

namespace kinemesh::test::synthetic_face_test {
namespace {

using enum Expression;

ExpressionWeights weights(std::initializer_list<Expression> expressions, double strength = 1) {
  ExpressionWeights w;
  for (const Expression e : expressions) w[e] = strength;
  return w;
}

const Slit& slit(const SyntheticFace& face, std::string_view name) {
  const auto& slits = face.rest().slits;
  return *std::find_if(slits.begin(), slits.end(), [&](const Slit& s) { return s.name == name; });
}

/// Largest distance between opposite vertices of a slit.
double gape(const SyntheticFace& face, std::string_view name, const ExpressionWeights& w) {
  const Slit& s = slit(face, name);
  double widest = 0;
  for (std::size_t k = 0; k < s.upper.size(); ++k) {
    widest = std::max(widest, (face.vertex(s.upper[k], w) - face.vertex(s.lower[k], w)).norm());
  }
  return widest;
}

std::vector<double> nearest_distances(const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (i != j) nearest[i] = std::min(nearest[i], (points[i] - points[j]).norm());
    }
  }
  return nearest;
}

class SyntheticFaces : public testing::TestWithParam<uint64_t> {
 protected:
  std::shared_ptr<const SyntheticFace> face = make_face({.seed = GetParam()});
};
INSTANTIATE_TEST_SUITE_P(Seeds, SyntheticFaces, testing::Values(0, 1, 2, 21, 34));

TEST_P(SyntheticFaces, IsADiskWithThreeOpenings) {
  const Topology& topology = face->topology();
  EXPECT_TRUE(topology.is_manifold());
  EXPECT_EQ(topology.component_count(), 1U);
  EXPECT_EQ(topology.isolated_vertex_count(), 0U);
  EXPECT_EQ(topology.boundary_loops().size(), 4U);  // the rim, the mouth, two eyes
  EXPECT_EQ(topology.euler_characteristic(), 1 - 3);
  const TrueSurface closed = close_slits(face->rest(), {});
  EXPECT_TRUE(closed.topology->is_manifold());
  EXPECT_EQ(closed.topology->boundary_loops().size(), 1U);
}

TEST_P(SyntheticFaces, FacesForwardAndIsTheSizeOfAHead) {
  const auto& p = face->rest().positions;
  Eigen::Vector3d area = Eigen::Vector3d::Zero(), low = p[0], high = p[0];
  for (const Triangle& t : face->topology().faces()) {
    area += (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]) / 2;
  }
  for (const Eigen::Vector3d& q : p) {
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  EXPECT_GT(area.z(), 15000);  // the projection towards the front, mm²
  EXPECT_GT((high - low).x(), 130);
  EXPECT_LT((high - low).x(), 190);
  EXPECT_GT((high - low).y(), 160);
  EXPECT_LT((high - low).y(), 220);
}

TEST_P(SyntheticFaces, NoTriangleIsDegenerateOrTurnedOver) {
  for (const auto& w :
       {weights({}), weights({jaw_open}), weights({smile_left, smile_right, lips_part}),
        weights({brow_raise_left, brow_raise_right, eyes_wide}), weights({pucker, cheek_puff}),
        weights({frown, nose_wrinkle})}) {
    const TrueSurface s = face->surface(w);
    const auto& rest = face->rest().positions;
    std::size_t flat = 0, turned = 0;
    for (const Triangle& t : s.topology->faces()) {
      const auto normal = [&](const auto& p) -> Eigen::Vector3d {
        return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
      };
      flat += normal(s.positions).norm() < 0.01 ? 1 : 0;
      turned += normal(s.positions).dot(normal(rest)) < 0 ? 1 : 0;
    }
    EXPECT_EQ(flat, 0U);
    EXPECT_LE(turned, s.topology->face_count() / 500);  // steep skin beside the lips may turn
  }
}

TEST_P(SyntheticFaces, LipsPartAndLidsOpenAndShut) {
  EXPECT_NEAR(gape(*face, "mouth", {}), 0, 1e-9);
  EXPECT_GT(gape(*face, "mouth", weights({jaw_open})), 20);
  EXPECT_LT(gape(*face, "mouth", weights({jaw_open})), 50);
  EXPECT_GT(gape(*face, "mouth", weights({lips_part})), 4);
  EXPECT_NEAR(gape(*face, "mouth", weights({pucker, smile_left, brow_raise_left, frown})), 0, 1e-9);
  for (const char* eye : {"left_eye", "right_eye"}) {
    EXPECT_GT(gape(*face, eye, {}), 6);
    EXPECT_GT(gape(*face, eye, weights({eyes_wide})), gape(*face, eye, {}) + 1.5);
    EXPECT_NEAR(gape(*face, eye, weights({blink_left, blink_right})), 0, 1e-9);
  }
  EXPECT_GT(gape(*face, "left_eye", weights({blink_right})), 6);
}

TEST_P(SyntheticFaces, MovesWhereItShould) {
  const auto moved = [&](const Eigen::Vector2d& place,
                         const ExpressionWeights& w) -> Eigen::Vector3d {
    const SurfacePoint p = face->locate(place);
    return face->point(p, w) - face->point(p, {});
  };
  EXPECT_LT(moved({0, -64}, weights({jaw_open})).y(), -15);       // chin
  EXPECT_LT(moved({0, 60}, weights({jaw_open})).norm(), 1e-9);    // forehead
  EXPECT_GT(moved({30, -34}, weights({smile_left})).y(), 3);      // its own corner, up
  EXPECT_GT(moved({30, -34}, weights({smile_left})).x(), 1);      // and outwards
  EXPECT_LT(moved({-30, -34}, weights({smile_left})).norm(), 1);  // the other one stays
  EXPECT_GT(moved({28, 52}, weights({brow_raise_left})).y(), 4);
  EXPECT_GT(moved({3, -38}, weights({pucker})).z(), 3);
  EXPECT_GT(moved({42, -26}, weights({cheek_puff})).norm(), 4);
}

TEST_P(SyntheticFaces, PointsAreFoundByTheirPlace) {
  for (double u = -110; u < 111; u += 13.7) {
    for (double v = -90; v < 91; v += 11.3) {
      const SurfacePoint p = face->locate({u, v});
      EXPECT_NEAR(face->domain(p).x(), u, 1e-9);
      EXPECT_NEAR(face->domain(p).y(), v, 1e-9);
      for (const double w : p.weights) EXPECT_GE(w, 0);
    }
  }
}

TEST_P(SyntheticFaces, MarkersKeepTheirDistanceAndSitOffTheVertices) {
  for (const double spacing : {9.0, 12.0, 17.0}) {
    const MarkerLayout layout = place_markers(*face, spacing, GetParam());
    const auto positions = positions_of(face->rest(), layout.points);
    auto nearest = nearest_distances(positions);
    std::sort(nearest.begin(), nearest.end());
    EXPECT_GE(nearest.front(), 0.75 * spacing);  // rows are denser
    EXPECT_GE(nearest[nearest.size() / 5], 0.85 * spacing);
    EXPECT_LE(nearest[nearest.size() * 9 / 10], 1.35 * spacing);
    for (const SurfacePoint& p : layout.points) {
      EXPECT_LT(std::max({p.weights[0], p.weights[1], p.weights[2]}), 1 - 1e-6);
    }
  }
}

TEST_P(SyntheticFaces, MarkersRingTheOpenings) {
  const MarkerLayout layout = place_markers(*face, 9, GetParam());
  for (const SlitSegment& s : slit_segments) {
    std::size_t above = 0, below = 0, beyond = 0;
    for (const Eigen::Vector2d& d : layout.domain) {
      const bool near = std::abs(d.y() - s.v) < 9.5;
      const bool along = d.x() > s.u_begin && d.x() < s.u_end;
      above += near && along && d.y() > s.v ? 1 : 0;
      below += near && along && d.y() < s.v ? 1 : 0;
      beyond += near && !along && d.x() > s.u_begin - 8 && d.x() < s.u_end + 8 ? 1 : 0;
    }
    EXPECT_GE(above, 3U) << s.name;
    EXPECT_GE(below, 3U) << s.name;
    EXPECT_GE(beyond, 2U) << s.name;
  }
}

TEST(SyntheticFace, CountsFollowTheSpacing) {
  const auto face = make_face({.seed = 1});
  const std::size_t dense = place_markers(*face, 8, 1).size();
  const std::size_t sparse = place_markers(*face, 18, 1).size();
  EXPECT_GT(dense, 220U);
  EXPECT_LT(dense, 280U);
  EXPECT_GT(sparse, 45U);
  EXPECT_LT(sparse, 80U);
  LayoutOptions ears{.spacing_mm = 9, .sideways = 95};
  EXPECT_GT(place_markers(*face, ears).size(), place_markers(*face, 9, 1).size() + 40);
}

TEST(SyntheticFace, TheSameSeedGivesTheSameFaceAndMarkers) {
  const auto a = make_face({.seed = 5}), b = make_face({.seed = 5}), c = make_face({.seed = 6});
  EXPECT_EQ(a->rest().positions, b->rest().positions);
  EXPECT_NE(a->rest().positions, c->rest().positions);
  EXPECT_EQ(place_markers(*a, 9, 3).domain, place_markers(*b, 9, 3).domain);
  EXPECT_NE(place_markers(*a, 9, 3).domain, place_markers(*a, 9, 4).domain);
}

TEST(SyntheticFace, TheSameMarkerSetGoesOnAnotherSubject) {
  const auto anna = make_face({.seed = 21}), ben = make_face({.seed = 34});
  const MarkerLayout first = place_markers(*anna, 9.6, 1);
  const MarkerLayout second =
      transfer_markers(first, *ben, {.jitter_mm = 0.7, .missing = 4, .least_mm = 7, .seed = 2});
  EXPECT_EQ(second.size(), first.size() - 4);
  const auto pairs = correspondence_of(first, second);
  ASSERT_EQ(pairs.size(), second.size());
  double squares = 0;
  for (const auto& [i, j] : pairs) {
    EXPECT_EQ(first.labels[i], second.labels[j]);
    squares += (first.domain[i] - second.domain[j]).squaredNorm();
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(pairs.size())), 2.0);
  const auto nearest = nearest_distances(positions_of(ben->rest(), second.points));
  EXPECT_GE(*std::min_element(nearest.begin(), nearest.end()), 6.9);
}

TEST(SyntheticFace, RefusesAGridThatMissesTheSlits) {
  EXPECT_THROW(make_face({.seed = 1, .vertex_spacing_mm = 3}), UsageError);
}

TEST(SyntheticBodies, HaveTheTopologyTheyClaim) {
  const auto check = [](const TrueSurface& s, int64_t euler, std::size_t loops) {
    EXPECT_TRUE(s.topology->is_manifold());
    EXPECT_EQ(s.topology->component_count(), 1U);
    EXPECT_EQ(s.topology->euler_characteristic(), euler);
    EXPECT_EQ(s.topology->boundary_loops().size(), loops);
    double volume = 0;
    for (const Triangle& t : s.topology->faces()) {
      const auto& p = s.positions;
      volume += p[t[0]].dot(p[t[1]].cross(p[t[2]])) / 6;
    }
    EXPECT_GT(volume, 0) << "faces inwards";
  };
  check(make_sphere(50), 2, 0);
  check(make_blob(3), 2, 0);
  check(make_open_blob(3), 1, 1);
  check(make_bent_tube(60, 400, 90), 1, 1);
}

TEST(SyntheticBodies, MarkersKeepTheirDistance) {
  const TrueSurface blob = make_blob(4);
  const auto points = scatter_markers(blob, 50, 1);
  EXPECT_GT(points.size(), 80U);
  const auto nearest = nearest_distances(positions_of(blob, points));
  EXPECT_GE(*std::min_element(nearest.begin(), nearest.end()), 50);
}

}  // namespace
}  // namespace kinemesh::test::synthetic_face_test
