#include "mesh/geodesics/geodesic_output.h"

#include <cmath>
#include <cstring>
#include <string>

#include "config/error.h"
#include "config/text.h"
#include "mesh/formats/npz.h"

namespace kinemesh {
namespace {

std::string number(double value) { return std::isfinite(value) ? format_number(value) : "inf"; }

std::string distances_csv(const GeodesicField& field) {
  std::string text = "vertex,distance\n";
  for (std::size_t v = 0; v < field.distances.size(); ++v) {
    text += std::to_string(v) + "," + number(field.distances[v]) + "\n";
  }
  return text;
}

std::string paths_csv(const Mesh& mesh, std::span<const GeodesicPath> paths) {
  std::string text = "path,x,y,z,face,b0,b1,b2\n";
  for (std::size_t i = 0; i < paths.size(); ++i) {
    for (const SurfacePoint& p : paths[i].points) {
      const Eigen::Vector3d place = position_of(p, *mesh.topology, mesh.positions);
      text += std::to_string(i);
      for (int axis = 0; axis < 3; ++axis) text += "," + number(place[axis]);
      text += "," + std::to_string(p.face);
      for (const double w : p.weights) text += "," + number(w);
      text += "\n";
    }
  }
  return text;
}

template <class T>
void append_binary(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string distances_ply(const Mesh& mesh, const GeodesicField& field) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment unit mm\n"
      "comment quality: geodesic distance in mm\nelement vertex " +
      std::to_string(mesh.positions.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty float quality\n"
      "element face " +
      std::to_string(mesh.topology->face_count()) +
      "\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis) append_binary(bytes, mesh.positions[v][axis]);
    append_binary(bytes, static_cast<float>(field.distances[v]));
  }
  for (const Triangle& face : mesh.topology->faces()) {
    append_binary(bytes, uint8_t{3});
    for (const VertexIndex v : face) append_binary(bytes, static_cast<int32_t>(v));
  }
  return bytes;
}

std::string paths_ply(const Mesh& mesh, std::span<const GeodesicPath> paths) {
  std::string points, edges;
  std::size_t point_count = 0, edge_count = 0;
  for (const GeodesicPath& path : paths) {
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const Eigen::Vector3d place = position_of(path.points[i], *mesh.topology, mesh.positions);
      for (int axis = 0; axis < 3; ++axis) points += (axis > 0 ? " " : "") + number(place[axis]);
      points += "\n";
      if (i > 0) {
        edges += std::to_string(point_count - 1) + " " + std::to_string(point_count) + "\n";
        ++edge_count;
      }
      ++point_count;
    }
  }
  return "ply\nformat ascii 1.0\ncomment unit mm\nelement vertex " + std::to_string(point_count) +
         "\nproperty double x\nproperty double y\nproperty double z\nelement edge " +
         std::to_string(edge_count) + "\nproperty int vertex1\nproperty int vertex2\nend_header\n" +
         points + edges;
}

std::string archive(const Mesh& mesh, const GeodesicField& field,
                    std::span<const GeodesicPath> paths) {
  NpzWriter writer;
  writer.add("distances", {field.distances.size()}, field.distances);
  if (!field.nearest_source.empty()) {
    std::vector<int64_t> nearest;
    for (const uint32_t s : field.nearest_source) {
      nearest.push_back(s == invalid_index ? -1 : static_cast<int64_t>(s));
    }
    writer.add("nearest_source", {nearest.size()}, nearest);
  }
  std::vector<double> sources;
  for (const SurfacePoint& p : field.sources) {
    sources.insert(sources.end(),
                   {static_cast<double>(p.face), p.weights[0], p.weights[1], p.weights[2]});
  }
  writer.add("sources", {field.sources.size(), 4}, sources);
  std::vector<double> places, weights;
  std::vector<int64_t> faces, starts;
  for (const GeodesicPath& path : paths) {
    starts.push_back(static_cast<int64_t>(faces.size()));
    for (const SurfacePoint& p : path.points) {
      const Eigen::Vector3d place = position_of(p, *mesh.topology, mesh.positions);
      places.insert(places.end(), {place.x(), place.y(), place.z()});
      weights.insert(weights.end(), p.weights.begin(), p.weights.end());
      faces.push_back(static_cast<int64_t>(p.face));
    }
  }
  writer.add("path_points", {faces.size(), 3}, places);
  writer.add("path_faces", {faces.size()}, faces);
  writer.add("path_weights", {faces.size(), 3}, weights);
  writer.add("path_starts", {starts.size()}, starts);
  return writer.bytes();
}

}  // namespace

std::filesystem::path path_file(const std::filesystem::path& path) {
  return path.parent_path() / (path.stem().string() + "_path" + path.extension().string());
}

void check_distance_path(const std::filesystem::path& path) {
  const std::string extension = lower(path.extension().string());
  for (const char* known : {".csv", ".npz", ".ply", ".png"}) {
    if (extension == known) return;
  }
  throw UsageError({.what = "distances are written as .csv, .npz, .ply or .png, not as '" +
                            path.filename().string() + "'"});
}

void add_distance_files(OutputSet& files, const std::filesystem::path& path, const Mesh& mesh,
                        const GeodesicField& field, std::span<const GeodesicPath> paths) {
  check_distance_path(path);
  const std::string extension = lower(path.extension().string());
  if (extension == ".csv") {
    files.add(path, distances_csv(field));
    if (!paths.empty()) files.add(path_file(path), paths_csv(mesh, paths));
  } else if (extension == ".ply") {
    files.add(path, distances_ply(mesh, field));
    if (!paths.empty()) files.add(path_file(path), paths_ply(mesh, paths));
  } else if (extension == ".npz") {
    files.add(path, archive(mesh, field, paths));
  } else {
    throw InternalError("add_distance_files: pictures are drawn by report/distance_view");
  }
}

}  // namespace kinemesh
