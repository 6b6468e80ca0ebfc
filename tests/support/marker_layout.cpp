#include "tests/support/marker_layout.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/support/random.h"

namespace kinemesh::test {

namespace {

constexpr double closest = 0.89;  // of the spacing

/// The marked part of the domain: from the forehead to under the chin, narrower at both ends.
bool marked(const Eigen::Vector2d& d, const LayoutOptions& o) {
  if (d.y() < o.bottom || d.y() > o.top) return false;
  const double low = std::max(0.0, -d.y() / std::abs(o.bottom));
  const double high = std::max(0.0, (d.y() - 20) / (o.top - 20));
  return std::abs(d.x()) < o.sideways * (1 - 0.42 * low * low - 0.25 * high * high * high);
}

struct RingShape {
  double upper, lower, beyond;  // mm in the domain from the slit and its ends
};

/// Places on a curve around a slit, evenly spaced over the surface at rest.
std::vector<Eigen::Vector2d> ring_around(const SyntheticFace& face, const SlitSegment& slit,
                                         const RingShape& shape, double spacing) {
  const double middle = 0.5 * (slit.u_begin + slit.u_end);
  const double half = 0.5 * (slit.u_end - slit.u_begin) + shape.beyond;
  const auto curve = [&](double angle) -> Eigen::Vector2d {
    const double c = std::cos(angle), s = std::sin(angle);
    const double up = s > 0 ? shape.upper : shape.lower;
    return {middle + half * c, slit.v + up * std::copysign(std::pow(std::abs(s), 0.6), s)};
  };
  const auto place = [&](double angle) {
    return position_of(face.locate(curve(angle)), face.topology(), face.rest().positions);
  };
  std::vector<Eigen::Vector2d> ring;
  for (int side = 0; side < 2; ++side) {  // from corner to corner above, then below
    constexpr int steps = 400;
    std::vector<double> length{0};
    const double begin = side * std::numbers::pi;
    for (int k = 1; k <= steps; ++k) {
      const double step = std::numbers::pi / steps;
      length.push_back(length.back() +
                       (place(begin + k * step) - place(begin + (k - 1) * step)).norm());
    }
    const int count = std::max(2, static_cast<int>(length.back() / spacing + 0.2));
    for (int k = 0; k < count; ++k) {
      const auto at = std::lower_bound(length.begin(), length.end(), k * length.back() / count);
      ring.push_back(
          curve(begin + static_cast<double>(at - length.begin()) * std::numbers::pi / steps));
    }
  }
  return ring;
}

/// Between a row of markers and its slit there are no others.
bool inside_a_ring(const Eigen::Vector2d& d) {
  return std::any_of(slit_segments.begin(), slit_segments.end(), [&](const SlitSegment& slit) {
    const double along = std::max({slit.u_begin - d.x(), d.x() - slit.u_end, 0.0});
    return std::hypot(along, d.y() - slit.v) < 4.5;
  });
}

std::string region_of(const Eigen::Vector2d& d) {
  const double u = std::abs(d.x()), v = d.y();
  if (v > 55) return "FHD";
  if (v > 42) return u < 60 ? "BRO" : "TMP";
  if (u > 66) return v > 10 ? "TMP" : v > -25 ? "SID" : "JAW";
  if (v > 20) return u < 12 ? "NOS" : "EYE";
  if (v > -20) return u < 20 ? "NOS" : "CHK";
  if (v > -48) return u < 34 ? "MOU" : "CHK";
  return u < 26 ? "CHN" : "JAW";
}

std::string side_of(double u) { return u > 4 ? "L" : u < -4 ? "R" : "C"; }

std::vector<std::string> labels_of(const std::vector<Eigen::Vector2d>& places) {
  std::map<std::string, int> count;
  std::vector<std::string> labels;
  for (const Eigen::Vector2d& d : places) {
    const std::string region = side_of(d.x()) + region_of(d);
    const int number = ++count[region];
    labels.push_back(region + (number < 10 ? "0" : "") + std::to_string(number));
  }
  return labels;
}

class Placement {
 public:
  Placement(const SyntheticFace& face, double distance) : face_(face), distance_(distance) {}

  bool add(const Eigen::Vector2d& domain, double factor = 1) {
    const SurfacePoint point = face_.locate(domain);
    const Eigen::Vector3d p = position_of(point, face_.topology(), face_.rest().positions);
    const double least = factor * distance_;
    for (const Eigen::Vector3d& other : positions_) {
      if ((other - p).squaredNorm() < least * least) return false;
    }
    positions_.push_back(p);
    places_.push_back(domain);
    return true;
  }
  const std::vector<Eigen::Vector2d>& places() const { return places_; }

 private:
  const SyntheticFace& face_;
  double distance_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<Eigen::Vector2d> places_;
};

/// Moves places that are closer than `least` on the face apart, a little at a time.
void move_apart(const SyntheticFace& face, double least, std::vector<Eigen::Vector2d>& places) {
  for (int round = 0; round < 60; ++round) {
    std::vector<Eigen::Vector3d> p;
    for (const Eigen::Vector2d& d : places) {
      p.push_back(position_of(face.locate(d), face.topology(), face.rest().positions));
    }
    bool moved = false;
    for (std::size_t i = 0; i < places.size(); ++i) {
      for (std::size_t j = i + 1; j < places.size(); ++j) {
        const double distance = (p[i] - p[j]).norm();
        if (distance >= least) continue;
        const Eigen::Vector2d push =
            0.3 * (least - distance) * (places[i] - places[j]).normalized();
        places[i] += push;
        places[j] -= push;
        moved = true;
      }
    }
    if (!moved) return;
  }
}

MarkerLayout layout_of(const SyntheticFace& face, std::vector<Eigen::Vector2d> places) {
  MarkerLayout layout;
  for (const Eigen::Vector2d& d : places) layout.points.push_back(face.locate(d));
  layout.domain = std::move(places);
  return layout;
}

}  // namespace

MarkerLayout place_markers(const SyntheticFace& face, const LayoutOptions& options) {
  Random random(options.seed * 104729 + 7);
  Placement placement(face, closest * options.spacing_mm);
  if (options.rings) {
    for (const SlitSegment& slit : slit_segments) {
      const bool mouth = slit.name == "mouth";
      const double widen = std::max(0.0, options.spacing_mm - 9);
      const RingShape shape = mouth ? RingShape{6.5 + 0.3 * widen, 7.5 + 0.3 * widen, 3.5}
                                    : RingShape{5.5 + 0.3 * widen, 6 + 0.3 * widen, 4};
      for (Eigen::Vector2d d : ring_around(face, slit, shape, options.spacing_mm)) {
        d += 0.3 * Eigen::Vector2d(random.normal(), random.normal());
        placement.add(d, 0.85);
      }
    }
  }
  for (int attempt = 0; attempt < 40000; ++attempt) {
    const Eigen::Vector2d d(random.uniform(-options.sideways, options.sideways),
                            random.uniform(options.bottom, options.top));
    if (marked(d, options) && !(options.rings && inside_a_ring(d))) placement.add(d);
  }
  MarkerLayout layout = layout_of(face, placement.places());
  layout.labels = labels_of(layout.domain);
  return layout;
}

MarkerLayout place_markers(const SyntheticFace& face, double spacing_mm, uint64_t seed) {
  return place_markers(face, LayoutOptions{.spacing_mm = spacing_mm, .seed = seed});
}

MarkerLayout transfer_markers(const MarkerLayout& layout, const SyntheticFace& target,
                              const TransferOptions& options) {
  Random random(options.seed * 15485863 + 3);
  std::vector<std::size_t> order(layout.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  random.shuffle(order);
  order.resize(layout.size() - std::min(options.missing, layout.size()));
  std::sort(order.begin(), order.end());
  std::vector<Eigen::Vector2d> places;
  std::vector<std::string> labels;
  for (const std::size_t i : order) {
    Eigen::Vector2d moved = layout.domain[i];
    moved += options.jitter_mm * Eigen::Vector2d(random.normal(), random.normal());
    places.push_back(moved);
    labels.push_back(layout.labels[i]);
  }
  if (options.least_mm > 0) move_apart(target, options.least_mm, places);
  MarkerLayout result = layout_of(target, std::move(places));
  result.labels = std::move(labels);
  return result;
}

std::vector<std::pair<std::size_t, std::size_t>> correspondence_of(const MarkerLayout& first,
                                                                   const MarkerLayout& second) {
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < second.size(); ++i) index[second.labels[i]] = i;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const auto found = index.find(first.labels[i]);
    if (found != index.end()) pairs.emplace_back(i, found->second);
  }
  return pairs;
}

}  // namespace kinemesh::test
