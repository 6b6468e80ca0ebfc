#include "reconstruct/animate_scan.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "config/error.h"
#include "config/output_file.h"
#include "reconstruct/marker_places.h"
#include "reconstruct/prepare_scan.h"
#include "tests/support/data.h"
#include "tests/support/ict_performer.h"
#include "tests/support/samples.h"
#include "tests/support/synthetic_take.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::animate_scan_test {
namespace {

struct Recorded {
  Mesh scan;
  MarkerSequence session;
  std::vector<SurfacePoint> points;
};

/// A short sample with head motion and head rig, and its subject's surface at rest.
const Recorded& sample() {
  static const Recorded recorded = [] {
    const auto face = test::sample_face("anna");
    const auto layout = test::sample_layout("anna");
    test::TakeOptions options;
    options.duration_s = 3.5;
    options.rate_hz = 12;
    options.head_degrees = 6;
    options.head_mm = 25;
    options.head_rig = true;
    Recorded r;
    r.session =
        test::make_take(face, layout, test::make_motion(test::MotionKind::happy), options).measured;
    r.scan.topology = face->rest().topology;
    for (const auto& p : face->rest().positions) r.scan.positions.push_back(p.cast<float>());
    r.points = layout.points;
    return r;
  }();
  return recorded;
}

/// Largest distance in mm between where markers were attached and where they are.
double worst_place(const AnimateResult& result, const Mesh& scan,
                   const std::vector<SurfacePoint>& truth) {
  double worst = 0.0;
  for (std::size_t i = 0; i < result.registration.kept.size(); ++i) {
    const Eigen::Vector3d found = position_of(result.registration.markers[i].point,
                                              *result.scan.topology, result.scan.positions);
    const Eigen::Vector3d place =
        position_of(truth[result.registration.kept[i]], *scan.topology, scan.positions);
    worst = std::max(worst, (found - place).norm());
  }
  return worst;
}

bool noted(const AnimateResult& result, const std::string& words) {
  return std::ranges::any_of(
      result.notes, [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

TEST(AnimateScan, MarkersAreFoundOnTheScan) {
  const AnimateResult result = animate_scan(sample().scan, sample().session);
  EXPECT_EQ(result.registration.kept.size(), sample().points.size());
  EXPECT_LT(worst_place(result, sample().scan, sample().points), 2.0);
  EXPECT_EQ(result.drive.animation.frame_count(), sample().session.frame_count());
  EXPECT_EQ(result.openings, 4U);
  EXPECT_FALSE(noted(result, "scan")) << "rim, eyes and mouth ask for nothing";
}

TEST(AnimateScan, PlacesAreThoseOfTheFacesInTheScansFile) {
  const auto from = Topology::create(4, {{0, 1, 2}, {0, 2, 3}});
  const auto to = Topology::create(4, {{0, 2, 1}, {2, 3, 0}});
  const auto moved = with_corners_of(
      {{"A", {0, {0.2, 0.3, 0.5}}, 1.0}, {"B", {1, {0.1, 0.2, 0.7}}, 0.0}}, *from, *to);
  EXPECT_EQ(moved[0].point.weights, (std::array<double, 3>{0.2, 0.5, 0.3}));
  EXPECT_EQ(moved[1].point.weights, (std::array<double, 3>{0.2, 0.7, 0.1}));
  EXPECT_EQ(with_corners_of(moved, *to, *from)[1].point.weights,
            (std::array<double, 3>{0.1, 0.2, 0.7}));
}

TEST(AnimateScan, OnAFaceModelWithHeadMotionEveryMarkerIsWithinTwoMillimetres) {
  KINEMESH_NEED_DATA("face_ict/meta.json");
  const test::IctModel& model = test::ict_model();
  const auto points = test::place_ict_markers(model, 9.0, 5);
  const test::IctActor actor(model, {.seed = 6}, test::make_ict_motion(model, 3, 2.0));
  test::TakeOptions options;
  options.rate_hz = 20;
  options.noise_mm = 0.2;
  options.head_degrees = 6;
  options.head_mm = 25;
  const test::IctTake take = test::record_ict(actor, points, options);
  Mesh scan{model.topology, {}, {}};
  for (const auto& p : actor.rest()) scan.positions.push_back(p.cast<float>());
  const AnimateResult result = animate_scan(scan, take.measured);
  EXPECT_EQ(result.registration.kept.size(), points.size());
  EXPECT_LT(worst_place(result, scan, points), 2.0);
}

TEST(AnimateScan, GivenPlacesAreKeptAndReadBack) {
  const test::TemporaryFolder folder;
  std::vector<AttachedMarker> places;
  for (std::size_t m = 0; m < sample().points.size(); ++m) {
    places.push_back({sample().session.markers()[m].label, sample().points[m], 0.25});
  }
  const auto path = folder.path() / "points.csv";
  write_file(path, marker_places_csv(places));
  const auto again = read_marker_places(path, sample().scan);
  ASSERT_EQ(again.size(), places.size());
  for (std::size_t m = 0; m < places.size(); ++m) {
    EXPECT_EQ(again[m].label, places[m].label);
    EXPECT_EQ(again[m].point.face, places[m].point.face);
    EXPECT_EQ(again[m].point.weights, places[m].point.weights);
    EXPECT_EQ(again[m].stand_off_mm, 0.25);
  }
  for (auto& p : places) p.stand_off_mm = 0.0;
  const AnimateResult result =
      animate_scan(sample().scan, sample().session, [&](const Mesh&, double) { return places; });
  EXPECT_LT(worst_place(result, sample().scan, sample().points), 1e-6);
  EXPECT_LT(result.registration.rms_mm, 0.6);
}

TEST(AnimateScan, MalformedPlacesAreRefusedWithTheLine) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "points.csv";
  for (const char* text :
       {"", "label,face,b0,b1,b2\n", "a,b,c\n1,2,3\n", "label,vertex\nA,99999999\n",
        "label,vertex\nA,-1\n", "label,vertex\nA,x\n", "label,vertex\nA,1\nA,2\n",
        "label,face,b0,b1,b2\nA,0,0.5,0.5,0.5\n", "label,x,y,z\nA,9999,0,0\n",
        "label,x,y,z\nA,nan,0,0\n", "label,vertex\nA\n"}) {
    write_file(path, text);
    EXPECT_THROW(read_marker_places(path, sample().scan), InputError) << text;
  }
}

TEST(AnimateScan, AScanInMetresIsScaledAndSaidSo) {
  Mesh metres = sample().scan;
  for (auto& p : metres.positions) p *= 0.001F;
  const AnimateResult result = animate_scan(metres, sample().session);
  EXPECT_EQ(result.scale, 1000.0);
  EXPECT_TRUE(noted(result, "scaled by 1000"));
  EXPECT_LT(worst_place(result, sample().scan, sample().points), 2.0);
  for (auto& p : metres.positions) p *= 1e-7F;
  EXPECT_THROW(animate_scan(metres, sample().session), NoResultError);
}

TEST(AnimateScan, FlippedNormalsTwoComponentsAndHolesAreCorrectedOrSaid) {
  const Mesh& good = sample().scan;
  std::vector<Triangle> faces = good.topology->faces();
  for (Triangle& t : faces) std::swap(t[1], t[2]);
  Mesh scan{Topology::create(good.positions.size(), faces), good.positions, {}};
  PreparedScan prepared = prepare_scan(scan);
  EXPECT_EQ(prepared.turned_faces, faces.size());
  EXPECT_EQ(prepared.mesh.topology->faces().size(), faces.size());
  EXPECT_TRUE(prepare_scan(good).turned_faces == 0);
  // Every third face the wrong way, one face cut out, and a part of its own.
  faces = good.topology->faces();
  for (std::size_t f = 0; f < faces.size(); f += 3) std::swap(faces[f][1], faces[f][2]);
  faces.erase(faces.begin() + 6000);
  const auto n = static_cast<VertexIndex>(good.positions.size());
  scan.positions.insert(scan.positions.end(), {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}});
  faces.push_back({n, n + 1, n + 2});
  scan.topology = Topology::create(scan.positions.size(), faces);
  const AnimateResult result = animate_scan(scan, sample().session);
  EXPECT_TRUE(noted(result, "turned round"));
  EXPECT_TRUE(noted(result, "components"));
  EXPECT_TRUE(noted(result, "2 holes"));
  EXPECT_TRUE(result.scan.topology->is_manifold());
  EXPECT_LT((result.drive.animation.position(10, n) - scan.positions[n]).norm(), 1e-3F);
  EXPECT_LT(worst_place(result, good, sample().points), 2.0);
}

TEST(AnimateScan, MarkersOffTheScanAreLeftOutOrRefused) {
  MarkerSequence session = sample().session;
  for (std::size_t f = 0; f < session.frame_count(); ++f) {
    for (std::size_t m = 0; m < 3; ++m) session.position(f, m) += Eigen::Vector3f(0, -50, 0);
  }
  const AnimateResult result = animate_scan(sample().scan, session);
  EXPECT_EQ(result.registration.kept.size(), sample().points.size() - 3);
  EXPECT_TRUE(noted(result, "left out"));
  // All of them by a shift of the whole: the registration takes it off.
  session = sample().session;
  for (float& x : session.positions()) x += 50.0F;
  EXPECT_LT(worst_place(animate_scan(sample().scan, session), sample().scan, sample().points), 2.0);
}

TEST(AnimateScan, MirroredMarkersAreRefused) {
  MarkerSequence session = sample().session;
  for (std::size_t f = 0; f < session.frame_count(); ++f) {
    for (std::size_t m = 0; m < session.marker_count(); ++m) {
      session.position(f, m).x() = -session.position(f, m).x();
    }
  }
  std::vector<AttachedMarker> places;
  for (std::size_t m = 0; m < sample().points.size(); ++m) {
    places.push_back({session.markers()[m].label, sample().points[m], 0.0});
  }
  for (const bool given : {true, false}) {
    try {
      if (given) {
        animate_scan(sample().scan, session, [&](const Mesh&, double) { return places; });
      } else {
        animate_scan(sample().scan, session);
      }
      ADD_FAILURE() << "mirrored markers were taken; places given: " << given;
    } catch (const NoResultError& error) {
      EXPECT_NE(std::string(error.what()).find("mirror"), std::string::npos) << error.what();
      EXPECT_FALSE(error.details().remedy.empty());
    }
  }
}

TEST(AnimateScan, WhatWouldNotFitIntoMemoryIsRefusedBeforeTheWork) {
  AnimateOptions options;
  options.memory_gb = 0.01;
  try {
    animate_scan(sample().scan, sample().session, {}, options);
    ADD_FAILURE() << "more memory was taken than allowed";
  } catch (const NoResultError& error) {
    EXPECT_NE(std::string(error.what()).find("GB of memory"), std::string::npos) << error.what();
    EXPECT_NE(error.details().remedy.find("c3d process"), std::string::npos);
  }
}

TEST(AnimateScan, ACloudOfPointsIsRefused) {
  Mesh cloud{Topology::create(10, {}), std::vector<Eigen::Vector3f>(10), {}};
  EXPECT_THROW(animate_scan(cloud, sample().session), NoResultError);
}

}  // namespace
}  // namespace kinemesh::animate_scan_test
