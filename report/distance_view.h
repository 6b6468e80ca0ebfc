// A picture of distances over a surface: colours, isolines, sources and paths.
#pragma once

#include <string>
#include <vector>

#include "config/run_context.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/mesh.h"
#include "report/canvas.h"

namespace kinemesh {

struct DistanceViewOptions {
  std::string title = "Geodesic distance";
  std::string subtitle;
};

/// The surface from two sides, with isolines at a round spacing and a colour bar. Parts
/// that no path reaches are grey.
Canvas draw_distances(const Mesh& mesh, const GeodesicField& field,
                      const std::vector<GeodesicPath>& paths,
                      const DistanceViewOptions& options = {}, const RunContext& ctx = {});

/// A spacing of 1, 2 or 5 times a power of ten that gives ten to twenty isolines up to `longest`.
double isoline_spacing(double longest);

}  // namespace kinemesh
