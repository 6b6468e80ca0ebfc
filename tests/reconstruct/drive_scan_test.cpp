#include "reconstruct/drive_scan.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>

#include "config/error.h"
#include "reconstruct/coarse_scan.h"
#include "reconstruct/marker_field.h"
#include "reconstruct/spread_product.h"
#include "tests/support/data.h"
#include "tests/support/ict_expressions.h"

namespace kinemesh::drive_scan_test {
namespace {

/// A flat sheet, slit from the middle of one side to its middle, 2 mm between vertices.
Mesh slit_sheet() {
  constexpr int n = 41;
  Mesh mesh;
  std::vector<Triangle> faces;
  const auto at = [](int x, int y) { return static_cast<VertexIndex>(y * n + x); };
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) mesh.positions.emplace_back(2.0F * x, 2.0F * y, 0.0F);
  }
  std::vector<VertexIndex> below(n, 0);  // the lower lip of the slit y = 20, x < 20
  for (int x = 0; x < 20; ++x) {
    below[static_cast<std::size_t>(x)] = static_cast<VertexIndex>(mesh.positions.size());
    mesh.positions.emplace_back(2.0F * x, 40.0F, 0.0F);
  }
  const auto corner = [&](int x, int y, bool lower) {
    return lower && y == 20 && x < 20 ? below[static_cast<std::size_t>(x)] : at(x, y);
  };
  for (int y = 0; y + 1 < n; ++y) {
    for (int x = 0; x + 1 < n; ++x) {
      const bool lower = y < 20;
      const VertexIndex a = corner(x, y, lower), b = corner(x + 1, y, lower),
                        c = corner(x + 1, y + 1, lower), d = corner(x, y + 1, lower);
      faces.push_back({a, b, c});
      faces.push_back({a, c, d});
    }
  }
  mesh.topology = Topology::create(mesh.positions.size(), std::move(faces));
  return mesh;
}

/// Markers in the middle of the faces nearest to a grid, 10 mm apart.
std::vector<AttachedMarker> grid_markers(const Mesh& mesh) {
  std::vector<AttachedMarker> markers;
  for (FaceIndex f = 0; f < mesh.topology->face_count(); f += 2) {
    const auto cell = static_cast<int>(f / 2);
    const int x = cell % 40, y = cell / 40;
    if (x % 5 != 2 || y % 5 != 2) continue;
    markers.push_back({"M" + std::to_string(markers.size()), {f, {0.2, 0.3, 0.5}}, 0.0});
  }
  return markers;
}

MarkerSequence take_of(const Mesh& mesh, const std::vector<AttachedMarker>& markers,
                       const std::vector<Eigen::Vector3f>& moves, std::size_t frames = 1,
                       double rate = 100.0) {
  std::vector<Marker> labels;
  for (const auto& m : markers) labels.push_back({.label = m.label});
  MarkerSequence take = MarkerSequence::invalid(frames, labels, rate);
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t m = 0; m < markers.size(); ++m) {
      take.position(f, m) =
          position_of(markers[m].point, *mesh.topology, mesh.positions).cast<float>() + moves[m];
      take.flags()[take.sample(f, m)] = SampleFlag::valid;
    }
  }
  return take;
}

Eigen::Vector3d driven_at(const AnimatedMesh& mesh, std::size_t frame, const SurfacePoint& point) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; c < 3; ++c) {
    sum += point.weights[c] *
           mesh.position(frame, mesh.topology().faces()[point.face][c]).cast<double>();
  }
  return sum;
}

std::vector<Eigen::Vector3f> wild_moves(std::size_t count) {
  std::vector<Eigen::Vector3f> moves;
  for (std::size_t m = 0; m < count; ++m) {
    const auto t = static_cast<float>(m);
    moves.emplace_back(std::sin(2.1F * t), std::cos(1.3F * t), 3.0F * std::sin(0.7F * t));
  }
  return moves;
}

std::vector<Eigen::Vector3f> smooth_moves(const Mesh& mesh,
                                          const std::vector<AttachedMarker>& markers) {
  std::vector<Eigen::Vector3f> moves;
  for (const auto& m : markers) {
    const Eigen::Vector3d p = position_of(m.point, *mesh.topology, mesh.positions);
    moves.emplace_back(0.0F, static_cast<float>(std::cos(p.y() / 20.0)),
                       static_cast<float>(5.0 * std::sin(p.x() / 20.0)));
  }
  return moves;
}

TEST(DriveScan, EveryMethodIsExactAtTheMarkersWithoutSmoothing) {
  const Mesh mesh = slit_sheet();
  const auto markers = grid_markers(mesh);
  const MarkerSequence take = take_of(mesh, markers, wild_moves(markers.size()));
  for (const DriveMethod method : {DriveMethod::surface, DriveMethod::geodesic,
                                   DriveMethod::biharmonic, DriveMethod::euclidean}) {
    DriveOptions options;
    options.method = method;
    options.smooth = false;
    const DriveResult driven = drive_scan(mesh, markers, take, options);
    for (std::size_t m = 0; m < markers.size(); ++m) {
      const Eigen::Vector3d place = driven_at(driven.animation, 0, markers[m].point);
      EXPECT_LT((place - take.position(0, m).cast<double>()).norm(), 2e-3)
          << m << " method " << static_cast<int>(method);
      EXPECT_LT(driven.marker_error_mm[m], 2e-3);
    }
  }
}

TEST(DriveScan, LipsOfASlitPartAndDoNotGlue) {
  const Mesh mesh = slit_sheet();
  const auto markers = grid_markers(mesh);
  std::vector<Eigen::Vector3f> moves;
  for (const auto& m : markers) {
    const Eigen::Vector3d p = position_of(m.point, *mesh.topology, mesh.positions);
    const bool slit = p.x() < 34.0;
    moves.emplace_back(0.0F, 0.0F, slit ? (p.y() > 40.0 ? 5.0F : -5.0F) : 0.0F);
  }
  const MarkerSequence take = take_of(mesh, markers, moves);
  DriveOptions options;
  options.smooth = false;
  const auto gap = [&](DriveMethod method) {
    options.method = method;
    const AnimatedMesh driven = drive_scan(mesh, markers, take, options).animation;
    // Upper and lower copy of the slit's vertex at x = 10 mm.
    const VertexIndex upper = 20 * 41 + 5, lower = 41 * 41 + 5;
    return driven.position(0, upper).z() - driven.position(0, lower).z();
  };
  EXPECT_GT(gap(DriveMethod::surface), 8.0F);
  EXPECT_GT(gap(DriveMethod::geodesic), 8.0F);
  EXPECT_LT(gap(DriveMethod::euclidean), 1e-3F);  // what distances in space do
}

TEST(DriveScan, ADecimatedSolveIsExactAtTheMarkersAndKeepsLipsApart) {
  const Mesh mesh = slit_sheet();
  const auto markers = grid_markers(mesh);
  const MarkerSequence take = take_of(mesh, markers, smooth_moves(mesh, markers));
  for (const DriveMethod method : {DriveMethod::surface, DriveMethod::geodesic,
                                   DriveMethod::biharmonic, DriveMethod::euclidean}) {
    DriveOptions options;
    options.method = method;
    options.smooth = false;
    const DriveResult whole = drive_scan(mesh, markers, take, options);
    EXPECT_EQ(whole.solved_faces, mesh.topology->face_count());
    options.most_faces = 1500;
    const DriveResult coarse = drive_scan(mesh, markers, take, options);
    EXPECT_LE(coarse.solved_faces, 1500U);
    EXPECT_EQ(coarse.animation.vertex_count(), mesh.positions.size());
    for (std::size_t m = 0; m < markers.size(); ++m) EXPECT_LT(coarse.marker_error_mm[m], 2e-3);
    if (method != DriveMethod::surface) continue;
    double largest = 0.0;
    for (VertexIndex v = 0; v < mesh.positions.size(); ++v) {
      const auto off = coarse.animation.position(0, v) - whole.animation.position(0, v);
      largest = std::max(largest, static_cast<double>(off.norm()));
    }
    EXPECT_LT(largest, 0.25) << "of motions of up to 5 mm";
  }
}

TEST(CoarseScan, VerticesStayOnTheirSideOfASlitAndLooseOnesHaveNoPlace) {
  Mesh mesh = slit_sheet();
  std::vector<Eigen::Vector3d> positions;
  for (const auto& p : mesh.positions) positions.push_back(p.cast<double>());
  positions.emplace_back(10.0, 10.0, 0.0);  // of no face
  const Topology topology(positions.size(), mesh.topology->faces());
  const CoarseScan coarse = coarsen_scan(topology, positions, 1500, 100.0);
  EXPECT_LE(coarse.topology->face_count(), 1500U);
  EXPECT_EQ(coarse.topology->boundary_loops().size(), 1U);
  EXPECT_FALSE(coarse.places.back().valid());
  for (std::size_t v = 0; v + 1 < positions.size(); ++v) {
    const Triangle& face = coarse.topology->faces()[coarse.places[v].face];
    double middle = 0.0;
    for (const VertexIndex c : face) middle += coarse.positions[c].y() / 3.0;
    // The slit's lower lip are the last vertices; both lips lie at y = 40.
    const bool lower = v >= 41U * 41U, upper = v >= 20U * 41U && v < 20U * 41U + 18U;
    if (lower && v < 41U * 41U + 18U) {
      EXPECT_LT(middle, 40.0);
    }
    if (upper) {
      EXPECT_GT(middle, 40.0);
    }
  }
  const Eigen::VectorXd ones =
      coarse.carry() * Eigen::VectorXd::Ones(static_cast<Eigen::Index>(coarse.positions.size()));
  EXPECT_NEAR(ones.head(ones.size() - 1).minCoeff(), 1.0, 1e-9);
  positions[3].x() = std::nan("");
  EXPECT_THROW(coarsen_scan(topology, positions, 1500, 100.0), InputError);
}

TEST(DriveScan, ChosenFramesAreDrivenAsAmongAll) {
  const Mesh mesh = slit_sheet();
  const auto markers = grid_markers(mesh);
  MarkerSequence take = take_of(mesh, markers, wild_moves(markers.size()), 9);
  take.first_frame = 101;
  for (std::size_t f = 0; f < 9; ++f) take.position(f, 7).z() += 0.1F * static_cast<float>(f);
  const AnimatedMesh all = drive_scan(mesh, markers, take).animation;
  DriveOptions options;
  options.frames = {.first = 4, .count = 3};
  const AnimatedMesh some = drive_scan(mesh, markers, take, options).animation;
  ASSERT_EQ(some.frame_count(), 3U);
  EXPECT_EQ(some.first_frame, 105);
  for (std::size_t f = 0; f < 3; ++f) {
    for (VertexIndex v = 0; v < some.vertex_count(); ++v) {
      ASSERT_EQ(some.position(f, v), all.position(f + 4, v));
    }
  }
}

TEST(DriveScan, AMarkerThatComesAndGoesMakesNoJump) {
  const Mesh mesh = slit_sheet();
  const auto markers = grid_markers(mesh);
  std::vector<Eigen::Vector3f> moves(markers.size(), Eigen::Vector3f::Zero());
  moves[20] = {0.0F, 0.0F, 4.0F};  // one that its neighbours would never predict
  MarkerSequence take = take_of(mesh, markers, moves, 120);
  for (std::size_t f = 40; f < 80; ++f) {
    take.flags()[take.sample(f, 20)] = SampleFlag::valid | SampleFlag::filled;
  }
  for (const bool smooth : {false, true}) {
    DriveOptions options;
    options.smooth = smooth;
    options.noise_mm = 0.2;
    const AnimatedMesh driven = drive_scan(mesh, markers, take, options).animation;
    double largest = 0.0;
    for (std::size_t f = 1; f < 120; ++f) {
      for (VertexIndex v = 0; v < driven.vertex_count(); ++v) {
        largest = std::max(
            largest,
            static_cast<double>((driven.position(f, v) - driven.position(f - 1, v)).norm()));
      }
    }
    EXPECT_LT(largest, 0.9) << smooth;
    const double inside = driven_at(driven, 60, markers[20].point).z();
    EXPECT_LT(inside, 0.5) << "in the middle of the gap the neighbours decide";
    EXPECT_GT(driven_at(driven, 10, markers[20].point).z(), 2.5);
  }
}

TEST(DriveScan, TheProductIsThatOfTheMatrices) {
  const Eigen::MatrixXf weights = Eigen::MatrixXf::Random(37, 13);
  const Eigen::MatrixXf moves = Eigen::MatrixXf::Random(13, 3 * 11);
  std::vector<float> rest(3 * 37);
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = static_cast<float>(i % 7);
  std::vector<float> one(11 * 37 * 3), two(one);
  RunContext single, several;
  single.set_threads(1);
  several.set_threads(4);
  PackedSpread(weights).apply(rest, moves, one, single);
  PackedSpread(weights).apply(rest, moves, two, several);
  EXPECT_EQ(one, two);
  const Eigen::MatrixXf expected = weights * moves;
  for (std::size_t f = 0; f < 11; ++f) {
    for (std::size_t v = 0; v < 37; ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(one[(f * 37 + v) * 3 + k],
                    rest[3 * v + k] + expected(static_cast<Eigen::Index>(v),
                                               static_cast<Eigen::Index>(3 * f + k)),
                    1e-4F);
      }
    }
  }
}

TEST(DriveScan, StandOffTurnsWithTheSkin) {
  const Mesh mesh = slit_sheet();
  auto markers = grid_markers(mesh);
  for (auto& m : markers) m.stand_off_mm = 5.0;
  // The whole sheet turned about the x axis by 30 degrees, markers standing off it.
  const Eigen::AngleAxisd turn(0.5236, Eigen::Vector3d::UnitX());
  std::vector<Marker> labels;
  for (const auto& m : markers) labels.push_back({.label = m.label});
  MarkerSequence take = MarkerSequence::invalid(1, labels, 100.0);
  for (std::size_t m = 0; m < markers.size(); ++m) {
    const Eigen::Vector3d foot = position_of(markers[m].point, *mesh.topology, mesh.positions);
    take.position(0, m) = (turn * (foot + Eigen::Vector3d(0, 0, 5.0))).cast<float>();
    take.flags()[m] = SampleFlag::valid;
  }
  DriveOptions options;
  options.smooth = false;
  const DriveResult driven = drive_scan(mesh, markers, take, options);
  for (std::size_t m = 0; m < markers.size(); ++m) {
    const Eigen::Vector3d foot = position_of(markers[m].point, *mesh.topology, mesh.positions);
    EXPECT_LT((driven_at(driven.animation, 0, markers[m].point) - turn * foot).norm(), 0.35) << m;
  }
}

TEST(DriveScan, BeatsTheEuclideanSplineOnEveryExpression) {
  KINEMESH_NEED_DATA("face_ict/meta.json");
  const auto ict = test::ict_expressions(3);
  const DriveResult ours = drive_scan(ict.scan, ict.markers, ict.measured);
  DriveOptions plain;
  plain.method = DriveMethod::euclidean;
  plain.smooth = false;
  const DriveResult spline = drive_scan(ict.scan, ict.markers, ict.measured, plain);
  const auto error = test::drive_error(ict, ours.animation);
  const auto reference = test::drive_error(ict, spline.animation);
  EXPECT_LT(error.mean, 2.0 / 3.0 * reference.mean);
  EXPECT_LT(error.p95, 2.0 / 3.0 * reference.p95);
  EXPECT_NEAR(ours.noise_mm, 0.2, 0.05);
  EXPECT_LE(ours.largest_change_mm, 2.5 * ours.noise_mm + 1e-9);
}

TEST(DriveScan, BadInputsAreNamed) {
  const Mesh mesh = slit_sheet();
  auto markers = grid_markers(mesh);
  const auto moves = wild_moves(markers.size());
  MarkerSequence take = take_of(mesh, markers, moves);
  take.flags()[3] = 0;
  EXPECT_THROW(drive_scan(mesh, markers, take), InputError);
  take.flags()[3] = SampleFlag::valid;
  markers[4].point = markers[5].point;
  EXPECT_THROW(drive_scan(mesh, markers, take), NoResultError);
  DriveOptions wrong;
  wrong.noise_mm = -1.0;
  EXPECT_THROW(drive_scan(mesh, markers, take, wrong), UsageError);
}

TEST(MarkerField, AbsenceRisesAndFallsSmoothly) {
  Eigen::Matrix<uint8_t, Eigen::Dynamic, Eigen::Dynamic> measured(1, 100);
  measured.setOnes();
  for (int f = 30; f < 70; ++f) measured(0, f) = 0;
  const Eigen::MatrixXf absence = absence_of(measured, 100.0, 0.1);
  EXPECT_EQ(absence(0, 29), 0.0F);
  EXPECT_EQ(absence(0, 50), 1.0F);
  for (int f = 1; f < 100; ++f) EXPECT_LT(std::abs(absence(0, f) - absence(0, f - 1)), 0.15F);
}

}  // namespace
}  // namespace kinemesh::drive_scan_test
