// The software rasteriser against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "config/error.h"
#include "report/mesh_view.h"

namespace kinemesh::raster_test {
namespace {

using Eigen::Vector3f;

constexpr Colour red{1, 0, 0, 1};
constexpr Colour blue{0, 0, 1, 1};

// A square of side 2 × half in the plane z, facing +z.
SceneMesh square(float half, float z, const Colour& colour) {
  SceneMesh mesh;
  mesh.topology = Topology::create(4, {{0, 1, 2}, {0, 2, 3}});
  mesh.positions = {{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}};
  mesh.colour = colour;
  return mesh;
}

// One pixel per mm, looking down −z, fully lit whatever the normal.
Camera one_to_one(int height) {
  Camera camera;
  camera.view_height = static_cast<float>(height);
  return camera;
}
RenderOptions flat_light(int width, int height) {
  RenderOptions options;
  options.width = width;
  options.height = height;
  options.ambient = 1.0F;
  return options;
}

double covered_area(const Image& image) {  // of a red figure on white
  double area = 0.0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) area += 1.0 - image.colour_at(x, y).g;
  }
  return area;
}

TEST(Raster, SquareCoversItsArea) {
  Scene scene;
  scene.meshes.push_back(square(10.25F, 0.0F, red));
  RenderOptions options = flat_light(40, 30);
  options.samples = 8;  // edges fall on quarter pixels, which 8 samples resolve exactly
  const Image image = render(scene, one_to_one(30), options).image;
  EXPECT_NEAR(covered_area(image), 20.5 * 20.5, 0.5);
  EXPECT_EQ(image.colour_at(20, 15).r, 1.0);
  EXPECT_EQ(image.colour_at(20, 15).g, 0.0);
  EXPECT_EQ(image.colour_at(2, 2).g, 1.0);
  // The square reaches a quarter into the pixel columns 9 and 30.
  EXPECT_NEAR(image.colour_at(9, 15).g, 0.75, 0.01);
  EXPECT_NEAR(image.colour_at(30, 15).g, 0.75, 0.01);
}

TEST(Raster, NearerSurfaceCoversWhateverTheOrder) {
  for (const bool swapped : {false, true}) {
    Scene scene;
    scene.meshes.push_back(swapped ? square(5, 1.0F, blue) : square(10, 0.0F, red));
    scene.meshes.push_back(swapped ? square(10, 0.0F, red) : square(5, 1.0F, blue));
    const RenderedScene view = render(scene, one_to_one(30), flat_light(30, 30));
    EXPECT_EQ(view.image.colour_at(15, 15).b, 1.0);
    EXPECT_EQ(view.image.colour_at(8, 15).r, 1.0);
    EXPECT_FLOAT_EQ(view.depth[15 * 30 + 15], 1.0F);
    EXPECT_FLOAT_EQ(view.depth[15 * 30 + 8], 0.0F);
    EXPECT_TRUE(std::isinf(view.depth[0]));
  }
}

TEST(Raster, ShadesByLambertsLaw) {
  for (const bool smooth : {false, true}) {
    for (const double degrees : {0.0, 30.0, 60.0}) {
      const auto angle = static_cast<float>(degrees * M_PI / 180.0);
      Scene scene;
      scene.meshes.push_back(square(10, 0, {1, 1, 1, 1}));
      scene.meshes[0].smooth = smooth;
      for (Vector3f& p : scene.meshes[0].positions) {  // turned about y
        p = Vector3f(p.x() * std::cos(angle), p.y(), -p.x() * std::sin(angle));
      }
      RenderOptions options = flat_light(30, 30);
      options.ambient = 0.25F;
      options.light = {0, 0, 2};
      options.background = {0, 0, 0, 1};
      const Image image = render(scene, one_to_one(30), options).image;
      EXPECT_NEAR(image.colour_at(15, 15).r, 0.25 + 0.75 * std::cos(angle), 0.5 / 255);
    }
  }
}

TEST(Raster, BackFacesAreTintedAndLitFromTheirSide) {
  Scene scene;
  scene.meshes.push_back(square(10, 0, red));
  scene.meshes[0].back_colour = blue;
  scene.meshes[0].topology = Topology::create(4, {{0, 2, 1}, {0, 3, 2}});
  RenderOptions options = flat_light(30, 30);
  options.ambient = 0.2F;
  options.light = {0, 0, 1};
  const Colour centre = render(scene, one_to_one(30), options).image.colour_at(15, 15);
  EXPECT_EQ(centre.r, 0.0);
  EXPECT_EQ(centre.b, 1.0);
}

TEST(Raster, SphereHasTheAreaOfItsDiskAndItsShade) {
  Scene scene;
  scene.spheres.push_back({.centre = {1.3F, -0.7F, 4.0F}, .radius = 20.0F, .colour = red});
  RenderOptions options = flat_light(60, 60);
  options.samples = 6;
  const RenderedScene view = render(scene, one_to_one(60), options);
  EXPECT_NEAR(covered_area(view.image), M_PI * 400.0, 2.0);
  EXPECT_NEAR(view.depth[30 * 60 + 31], 24.0, 0.1);
  options.ambient = 0.0F;
  options.light = {0, 0, 1};
  const Image lit = render(scene, one_to_one(60), options).image;
  // Twelve pixels beside the centre the normal has z = √(1 − 0.6²) = 0.8.
  EXPECT_NEAR(lit.colour_at(43, 30).r, std::sqrt(1.0 - std::pow(12.2 / 20.0, 2)), 0.01);
}

TEST(Raster, EdgesAndLinesHaveTheirWidth) {
  Scene scene;
  scene.meshes.push_back(square(12, 0, {1, 1, 1, 1}));
  scene.meshes[0].edge_width = 2.0;
  scene.meshes[0].edge_colour = {0, 0, 0, 1};
  RenderOptions options = flat_light(40, 40);
  options.samples = 4;
  Image image = render(scene, one_to_one(40), options).image;
  EXPECT_EQ(image.colour_at(19, 20).r, 0.0) << "the diagonal is drawn";
  EXPECT_EQ(image.colour_at(9, 20).r, 0.0) << "the rim is as wide as an inner edge";
  EXPECT_EQ(image.colour_at(11, 20).r, 1.0);

  Scene line;
  line.lines.push_back({{{-10, 0, 0}, {10, 0, 0}}, red, 4.0});
  image = render(line, one_to_one(40), options).image;
  EXPECT_NEAR(covered_area(image), 20.0 * 4.0 + M_PI * 4.0, 1.5) << "with round ends";
}

TEST(Raster, ValuesAreColouredByTheScale) {
  Scene scene;
  scene.meshes.push_back(square(10, 0, red));
  scene.meshes[0].values = {0, 1, 1, 0};  // grows from left to right
  scene.meshes[0].scale = {.low = 0.0, .high = 1.0};
  const Image image = render(scene, one_to_one(30), flat_light(30, 30)).image;
  for (const int x : {6, 12, 20}) {
    const Colour expected = scene.meshes[0].scale((x + 0.5 - 5.0) / 20.0);
    EXPECT_NEAR(image.colour_at(x, 15).r, expected.r, 0.02);
    EXPECT_NEAR(image.colour_at(x, 15).g, expected.g, 0.02);
    EXPECT_NEAR(image.colour_at(x, 15).b, expected.b, 0.02);
  }
}

TEST(Raster, SameBytesForAnyNumberOfThreads) {
  Scene scene;
  scene.meshes.push_back(square(40, 0, red));
  scene.meshes[0].edge_width = 1.5;
  for (int i = 0; i < 50; ++i) {
    scene.spheres.push_back({.centre = Vector3f(static_cast<float>(i % 7 * 10 - 30),
                                                static_cast<float>(i % 11 * 7 - 35), 0.0F),
                             .radius_px = 4.0F,
                             .colour = blue});
  }
  const Camera camera = one_to_one(100);
  RunContext one;
  RunContext two;
  one.set_threads(1);
  two.set_threads(2);
  const RenderOptions options = flat_light(150, 100);
  EXPECT_EQ(render(scene, camera, options, one).image.rgba,
            render(scene, camera, options, two).image.rgba);
}

TEST(Raster, BadInputIsDrawnWithoutItOrRefused) {
  Scene scene;
  scene.meshes.push_back(square(10, 0, red));
  scene.meshes[0].positions[3].x() = NAN;
  scene.spheres.push_back({.centre = {NAN, 0, 0}, .radius = 3.0F, .colour = red});
  scene.lines.push_back({{{0, 0, 0}, {INFINITY, 0, 0}}, red, 4.0});
  const Image image = render(scene, one_to_one(40), flat_light(40, 40)).image;
  EXPECT_NEAR(covered_area(image), 200.0, 5.0) << "the triangle that is whole";
  EXPECT_THROW(render(scene, one_to_one(40), flat_light(0, 40)), NoResultError);
  EXPECT_THROW(render(scene, one_to_one(40), flat_light(100000, 100000)), NoResultError);
  scene.meshes[0].positions.assign(4, {1e30F, -1e30F, 0});
  EXPECT_NO_THROW(render(scene, one_to_one(40), flat_light(40, 40)));
}

TEST(Camera, FaceIsSeenFromTheFrontUpright) {
  // An open symmetric dome about z, taller than wide, in a frame where x is up and −y the front.
  std::vector<Triangle> faces;
  std::vector<Vector3f> points;
  for (int r = 0; r < 9; ++r) {
    for (int c = 0; c < 7; ++c) {
      const float side = static_cast<float>(c) - 3.0F;
      const float height = static_cast<float>(r) - 4.0F;
      const float bulge = 3.0F - 0.1F * side * side - 0.05F * height * height - 0.06F * height;
      points.emplace_back(height + 0.02F * height * height, -bulge, side);
    }
  }
  for (uint32_t r = 0; r < 8; ++r) {
    for (uint32_t c = 0; c < 6; ++c) {
      const uint32_t a = 7 * r + c;
      faces.push_back({a, a + 7, a + 1});
      faces.push_back({a + 1, a + 7, a + 8});
    }
  }
  const Topology topology(points.size(), faces);
  const FrameView view(points[0].data(), static_cast<Eigen::Index>(points.size()), 3);
  const BodyAxes axes = estimate_axes(topology, view);
  EXPECT_GT(std::abs(axes.front.dot(-Vector3f::UnitY())), 0.95F);
  EXPECT_GT(axes.up.dot(Vector3f::UnitX()), 0.95F);
  EXPECT_GT(estimate_axes(topology, view, Vector3f(-2, 0, 0)).up.dot(-Vector3f::UnitX()), 0.999F);

  Camera camera = camera_for(View::front, axes);
  aim(camera, points, 1.0, 0.1);
  for (const Vector3f& p : points) {
    const Eigen::Vector2d at = camera.project(p, 100, 100);
    EXPECT_GE(at.minCoeff(), 9.9);
    EXPECT_LE(at.maxCoeff(), 90.1);
  }
}

}  // namespace
}  // namespace kinemesh::raster_test
