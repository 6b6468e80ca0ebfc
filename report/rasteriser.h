// The tile painter behind mesh_view. Private to report/.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "report/mesh_view.h"

namespace kinemesh::raster {

using Rgb = Eigen::Vector3f;

/// Lines drawn within a triangle.
struct Ink {
  Rgb colour = Rgb::Zero();
  float opacity = 0.0F;
  float half_width = 0.0F;  ///< in samples
};

/// A mesh in sample coordinates (x right, y down, in samples; z towards the viewer, in mm).
struct MeshData {
  const SceneMesh* mesh = nullptr;
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;  ///< view axes, unit; empty when flat
  std::vector<Rgb> colours;              ///< empty, or per vertex
  std::vector<Rgb> table;                ///< colour of value i of 1024; empty without values
  std::vector<uint8_t> boundary;         ///< per halfedge, 1 on the rim
  Rgb front, back;
  Ink edges;
  float samples_per_mm = 1.0F;
};

struct SphereData {
  Eigen::Vector3f centre;
  float radius;  ///< samples
  float samples_per_mm;
  Rgb colour;
};

struct SegmentData {
  Eigen::Vector3f from, to;
  float half_width;  ///< samples
  Rgb colour;
  float opacity;
};

struct Sample {
  float z;
  std::array<uint8_t, 4> rgba;
};

/// A square of samples, with the corner's sample coordinates.
class Tile {
 public:
  Tile(int x, int y, int width, int height, const Colour& background);
  int x() const { return x_; }
  int y() const { return y_; }
  int width() const { return width_; }
  int height() const { return height_; }
  Sample& at(int column, int row) { return samples_[row * width_ + column]; }
  const Sample& at(int column, int row) const { return samples_[row * width_ + column]; }

 private:
  int x_, y_, width_, height_;
  std::vector<Sample> samples_;
};

struct Shading {
  Eigen::Vector3f light = Eigen::Vector3f::UnitZ();  ///< unit
  float ambient = 0.3F;
  float operator()(const Eigen::Vector3f& unit_normal) const {
    return ambient + (1.0F - ambient) * std::max(0.0F, unit_normal.dot(light));
  }
};

void paint(Tile& tile, const MeshData& mesh, uint32_t face, const Shading& shading);
void paint(Tile& tile, const SphereData& sphere, const Shading& shading);
void paint(Tile& tile, const SegmentData& segment);

}  // namespace kinemesh::raster
