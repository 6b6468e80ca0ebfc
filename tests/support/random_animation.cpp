#include "tests/support/random_animation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kinemesh::test {
namespace {

std::shared_ptr<const Topology> grid(uint32_t columns, uint32_t rows) {
  std::vector<Triangle> faces;
  for (uint32_t r = 0; r + 1 < rows; ++r) {
    for (uint32_t c = 0; c + 1 < columns; ++c) {
      const uint32_t v = r * columns + c;
      faces.push_back({v, v + 1, v + columns});
      faces.push_back({v + 1, v + columns + 1, v + columns});
    }
  }
  return Topology::create(std::size_t{columns} * rows, std::move(faces));
}

}  // namespace

AnimatedMesh random_animation(uint32_t columns, uint32_t rows, std::size_t frames) {
  AnimatedMesh mesh(grid(columns, rows), frames, 119.88);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(-1.0F, 1.0F);
  std::uniform_int_distribution<int> exponent(-6, 4), percent(0, 99);
  for (float& x : mesh.positions()) x = std::ldexp(value(random), 3 * exponent(random));
  mesh.add_filled();
  mesh.add_uncertainty();
  for (std::size_t i = 0; i < mesh.filled().size(); ++i) {
    mesh.filled()[i] = percent(random) < 20 ? 1 : 0;
    mesh.uncertainty()[i] = mesh.filled()[i] != 0 ? std::abs(value(random)) : 0.0F;
  }
  mesh.first_frame = 1207;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    mesh.vertex_names.push_back("marker " + std::to_string(v));
  }
  mesh.vertex_names[1] = "ÄÖ \"quoted\" <&> back\\slash";
  mesh.events = {{"Foot \"Strike\"", "Left", "Anna", 1.0 / 3.0}, {"", "", "", 12.0}};
  mesh.provenance = {"kinemesh 0.1",
                     "kinemesh convert 'a b.c3d' -o x",
                     "[gaps]\nlimit = 0.5\n",
                     {{"a b.c3d", std::string(64, 'f')}},
                     "Anna, happy"};
  return mesh;
}

AnimatedMesh smooth_animation(uint32_t columns, uint32_t rows, std::size_t frames, double rate_hz) {
  AnimatedMesh mesh(grid(columns, rows), frames, rate_hz);
  for (std::size_t f = 0; f < frames; ++f) {
    const double t = static_cast<double>(f) / rate_hz;
    for (uint32_t v = 0; v < columns * rows; ++v) {
      const double x = 10.0 * (v % columns), y = 10.0 * (v / columns);
      const double bump = std::exp(-((x - 60) * (x - 60) + (y - 60) * (y - 60)) / 900.0);
      const double z = 0.002 * (x - 50) * (y - 40) + 8.0 * bump * std::sin(2.1 * t) +
                       1.5 * std::sin(0.05 * x + 3.0 * t) * std::cos(0.04 * y);
      mesh.position(f, v) = Eigen::Vector3d(x + 2.0 * std::sin(0.7 * t), y, z).cast<float>();
    }
  }
  return mesh;
}

void expect_same_positions(const AnimatedMesh& a, const AnimatedMesh& b) {
  ASSERT_EQ(a.vertex_count(), b.vertex_count());
  ASSERT_EQ(a.frame_count(), b.frame_count());
  for (std::size_t i = 0; i < a.positions().size(); ++i) {
    ASSERT_EQ(a.positions()[i], b.positions()[i]) << "value " << i;
  }
}

void expect_same_description(const AnimatedMesh& a, const AnimatedMesh& b) {
  EXPECT_EQ(a.topology(), b.topology());
  EXPECT_EQ(a.rate_hz, b.rate_hz);
  EXPECT_EQ(a.first_frame, b.first_frame);
  EXPECT_EQ(a.events, b.events);
  EXPECT_EQ(a.vertex_names, b.vertex_names);
  EXPECT_EQ(a.provenance.program, b.provenance.program);
  EXPECT_EQ(a.provenance.command, b.provenance.command);
  EXPECT_EQ(a.provenance.options, b.provenance.options);
  EXPECT_EQ(a.provenance.source, b.provenance.source);
  ASSERT_EQ(a.provenance.inputs.size(), b.provenance.inputs.size());
  for (std::size_t i = 0; i < a.provenance.inputs.size(); ++i) {
    EXPECT_EQ(a.provenance.inputs[i].path, b.provenance.inputs[i].path);
    EXPECT_EQ(a.provenance.inputs[i].sha256, b.provenance.inputs[i].sha256);
  }
}

}  // namespace kinemesh::test
