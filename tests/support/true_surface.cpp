#include "tests/support/true_surface.h"

#include <algorithm>
#include <numeric>

namespace kinemesh::test {

namespace {

constexpr double touching_mm = 1e-6;

void add_bridge(const Slit& slit, std::size_t k, const std::vector<VertexIndex>& image,
                std::vector<Triangle>& faces) {
  const VertexIndex a = image[slit.upper[k]], b = image[slit.upper[k + 1]];
  const VertexIndex c = image[slit.lower[k]], d = image[slit.lower[k + 1]];
  // The upper side's faces run along the slit in the direction of the columns (they lie on its
  // left), so the bridge runs against it.
  if (a != c && b != d) {
    faces.push_back({b, a, c});
    faces.push_back({b, c, d});
  } else if (a != c) {
    faces.push_back({b, a, c});
  } else if (b != d) {
    faces.push_back({b, a, d});
  }
}

}  // namespace

TrueSurface close_slits(const TrueSurface& surface, const std::vector<std::string>& open) {
  std::vector<VertexIndex> image(surface.positions.size());
  std::iota(image.begin(), image.end(), 0U);
  const auto stays_open = [&](const Slit& slit) {
    return std::find(open.begin(), open.end(), slit.name) != open.end();
  };
  TrueSurface closed{nullptr, surface.positions, surface.domain, {}};
  for (const Slit& slit : surface.slits) {
    if (stays_open(slit)) {
      closed.slits.push_back(slit);
      continue;
    }
    for (std::size_t k = 0; k < slit.upper.size(); ++k) {
      const auto& p = surface.positions;
      if ((p[slit.upper[k]] - p[slit.lower[k]]).norm() < touching_mm) {
        image[slit.lower[k]] = slit.upper[k];
      }
    }
  }
  std::vector<Triangle> faces = surface.topology->faces();
  for (Triangle& face : faces) {
    for (VertexIndex& v : face) v = image[v];
  }
  for (const Slit& slit : surface.slits) {
    if (stays_open(slit)) continue;
    for (std::size_t k = 0; k + 1 < slit.upper.size(); ++k) add_bridge(slit, k, image, faces);
  }
  closed.topology = Topology::create(surface.positions.size(), std::move(faces));
  return closed;
}

}  // namespace kinemesh::test
