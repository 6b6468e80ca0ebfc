#include "analysis/full_matching/composed_map.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "analysis/full_matching/smooth_deformation.h"
#include "analysis/spherical/rest_triangle.h"
#include "analysis/spherical/sphere_descent.h"
#include "analysis/spherical/unfold.h"
#include "config/error.h"

namespace kinemesh::full_matching {

namespace {

constexpr double filling_weight = 0.1;  // of the distortion of A's fillings
// A little of the distortion of A → sphere, so that what is tangled in a filling or a fold of B,
// where the other terms say little, comes free again; over the sphere's area, 4π.
constexpr double sphere_area = 4.0 * std::numbers::pi;
constexpr double sphere_weight = 0.02 / sphere_area;
// A smooth deformation that leaves more of the image's variance unexplained says nothing. Faces:
// about 0.002, limbs in another pose: 0.05 and more.
constexpr double unexplained_limit = 0.02;
constexpr double led_reach = 0.03;   // √area
constexpr double least_area = 4e-3;  // of an image triangle, squared, over the rest triangle's

}  // namespace

ComposedMap::ComposedMap(const ClosedSurface& closed, const SurfaceSignals& signals,
                         std::vector<Eigen::Vector3d> sphere, const Target& target)
    : closed_(closed),
      signals_(signals),
      target_(target),
      mesh_(*closed.topology),
      sphere_(std::move(sphere)),
      images_(sphere_.size()),
      held_(sphere_.size(), 0),
      room_(mesh_, sphere_, held_),
      own_values_(&signals.values),
      rest_values_(&target.signals.values),
      shortest_(1e-3 / std::sqrt(static_cast<double>(closed.topology->face_count()))) {
  for (const VertexIndex v : mesh_.alive()) images_[v] = image_of(sphere_[v], invalid_index);
}

void ComposedMap::coarsen(std::size_t count, std::span<const uint8_t> keep, const RunContext& ctx) {
  spherical::simplify(mesh_, signals_.positions, count, keep, ctx);
  if (keep.empty()) return;
  spherical::unfold(mesh_, signals_.positions, sphere_, ctx);
  for (const VertexIndex v : mesh_.alive())
    images_[v] = image_of(sphere_[v], images_[v].place.face);
}

void ComposedMap::refine(std::size_t count) {
  while (!complete() && mesh_.alive_count() < count) insert();
}

std::vector<std::size_t> ComposedMap::meet(std::span<const Anchor> anchors, const RunContext& ctx) {
  std::vector<std::size_t> away = warp_to_anchors(mesh_, signals_.positions, sphere_, anchors, ctx);
  for (const VertexIndex v : mesh_.alive())
    images_[v] = image_of(sphere_[v], images_[v].place.face);
  for (const Anchor& a : anchors) {
    if (sphere_[a.vertex] != a.goal) continue;
    held_[a.vertex] = 1;
    images_[a.vertex] = image_at(a.place);
  }
  return away;
}

void ComposedMap::insert() {
  const VertexIndex v = mesh_.next();
  const std::span<const VertexIndex> ring = mesh_.next_ring();
  const spherical::KernelPoint centre = room_.centre_of(ring);
  for (const VertexIndex r : room_.moved())
    images_[r] = image_of(sphere_[r], images_[r].place.face);
  sphere_[v] = centre.point;
  if (!(centre.distance > 0.0) || !spherical::star_is_valid(v, ring, sphere_)) {
    throw NoResultError({.what = "the map would fold at vertex " + std::to_string(v),
                         .remedy = "Remesh the surface so that its triangles are less thin"});
  }
  images_[v] = image_of(sphere_[v], images_[mesh_.next_onto()].place.face);
  mesh_.restore();
  descend(v);
  descend(v);
  for (const VertexIndex r : mesh_.ring(v)) descend(r);
}

void ComposedMap::set_weights(const Signal& weights, double distortion) {
  weights_ = weights;
  distortion_weight_ = distortion;
}

void ComposedMap::set_detail(double blur) {
  const double edge = blur * std::sqrt(1.15 / static_cast<double>(mesh_.alive_count()));
  own_values_ = &signals_.seen_by(edge);
  rest_values_ = &target_.signals.seen_by(edge);
  for (const VertexIndex v : mesh_.alive()) images_[v] = image_at(images_[v].place);
}

void ComposedMap::fit_rotation() {
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = mean_a;
  double total = 0.0;
  for (const VertexIndex v : mesh_.alive()) {
    mean_a += signals_.areas[v] * signals_.positions[v];
    mean_b += signals_.areas[v] * images_[v].position;
    total += signals_.areas[v];
  }
  mean_a /= total;
  mean_b /= total;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const VertexIndex v : mesh_.alive()) {
    covariance += signals_.areas[v] * (images_[v].position - mean_b) *
                  (signals_.positions[v] - mean_a).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  turn_ = (svd.matrixU() * flip * svd.matrixV().transpose()).cast<float>();
}

void ComposedMap::fit_deformation(double weight) {
  led_weights_.clear();
  if (!(weight > 0.0)) return;
  std::vector<Eigen::Vector3d> from, to;
  std::vector<double> areas;
  for (const VertexIndex v : mesh_.alive()) {
    if (!(signals_.areas[v] > 0.0)) continue;
    from.push_back(signals_.positions[v]);
    to.push_back(images_[v].position);
    areas.push_back(signals_.areas[v]);
  }
  if (from.size() < 5 * SmoothDeformation::terms) return;
  SmoothDeformation deformation;
  deformation.fit(from, to, areas);
  led_.resize(signals_.positions.size());
  for (std::size_t v = 0; v < led_.size(); ++v) led_[v] = deformation(signals_.positions[v]);
  const double trust = std::max(0.0, 1.0 - deformation.unexplained() / unexplained_limit);
  if (!(trust > 0.0)) return;
  // What lies far from where it is led (an ear) is not smooth, or told otherwise: it is let be.
  led_weights_.assign(led_.size(), 0.0);
  for (const VertexIndex v : mesh_.alive()) {
    const double astray = (images_[v].position - led_[v]).squaredNorm() / (led_reach * led_reach);
    led_weights_[v] = weight * trust / ((1.0 + astray) * (1.0 + astray));
  }
}

ComposedMap::Image ComposedMap::image_of(const Eigen::Vector3d& p, FaceIndex hint) const {
  return image_at(target_.locator.locate(p, hint));
}

ComposedMap::Image ComposedMap::image_at(const SurfacePoint& place) const {
  Image image{.place = place};
  const Triangle& face = target_.closed.topology->faces()[image.place.face];
  const auto& w = image.place.weights;
  image.position = w[0] * target_.signals.positions[face[0]] +
                   w[1] * target_.signals.positions[face[1]] +
                   w[2] * target_.signals.positions[face[2]];
  image.signal = static_cast<float>(w[0]) * (*rest_values_)[face[0]] +
                 static_cast<float>(w[1]) * (*rest_values_)[face[1]] +
                 static_cast<float>(w[2]) * (*rest_values_)[face[2]];
  return image;
}

Signal ComposedMap::own_signal(VertexIndex v) const {
  Signal signal = (*own_values_)[v];
  signal.head<3>() = turn_ * signal.head<3>();
  signal.segment<3>(first_tangent) = turn_ * signal.segment<3>(first_tangent);
  return signal;
}

void ComposedMap::gather(VertexIndex v) {
  const std::vector<VertexIndex>& ring = mesh_.ring(v);
  const bool filling = closed_.filling_vertex(v);
  corners_.resize(ring.size());
  own_area_ = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const VertexIndex b = ring[i], c = ring[i + 1 == ring.size() ? 0 : i + 1];
    const spherical::RestTriangle rest =
        spherical::rest_triangle(signals_.positions[v], signals_.positions[b],
                                 signals_.positions[c], spherical::map_slenderness, shortest_);
    Corner& k = corners_[i];
    k.b = sphere_[b];
    k.c = sphere_[c];
    k.normal = k.b.cross(k.c - k.b);
    k.image_b = images_[b].position;
    k.image_c = images_[c].position;
    k.cot_a = rest.cotangents[0];
    k.cot_b = rest.cotangents[1];
    k.cot_c = rest.cotangents[2];
    k.area = 4.0 * rest.area * rest.area;
    const bool outside = filling || closed_.filling_vertex(b) || closed_.filling_vertex(c);
    k.weight = outside ? filling_weight : 1.0;
    k.least_square = 1e-18 * k.normal.squaredNorm();
    if (!filling && !outside) own_area_ += rest.area / 3.0;
  }
}

bool ComposedMap::in_place(const Eigen::Vector3d& p) const {
  for (const Corner& k : corners_) {
    const Eigen::Vector3d from_b = p - k.b;
    const double determinant = from_b.dot(k.normal);
    if (!(determinant > 0.0) ||
        determinant * determinant <= k.least_square * from_b.squaredNorm()) {
      return false;
    }
  }
  return true;
}

double ComposedMap::distortion_energy(const Eigen::Vector3d& q) const {
  double energy = 0.0;
  for (const Corner& k : corners_) {
    const Eigen::Vector3d from_b = q - k.image_b, from_c = q - k.image_c;
    const double square = from_b.cross(from_c).squaredNorm() + least_area * k.area;
    const double stretch = (k.cot_a * (k.image_c - k.image_b).squaredNorm() +
                            k.cot_c * from_b.squaredNorm() + k.cot_b * from_c.squaredNorm()) /
                           2.0;
    energy += k.weight * stretch * (1.0 + k.area / square) / 4.0;
  }
  return energy;
}

double ComposedMap::sphere_energy(const Eigen::Vector3d& p) const {
  double energy = 0.0;
  for (const Corner& k : corners_) {
    const Eigen::Vector3d from_b = p - k.b;
    const double determinant = from_b.dot(k.normal);
    const double stretch = (k.cot_a * (k.c - k.b).squaredNorm() + k.cot_c * from_b.squaredNorm() +
                            k.cot_b * (p - k.c).squaredNorm()) /
                           2.0;
    energy += stretch * (1.0 + sphere_area * sphere_area * k.area / (determinant * determinant));
  }
  return sphere_weight * energy;
}

void ComposedMap::add_sphere_slope(const Eigen::Vector3d& p,
                                   const Eigen::Matrix<double, 3, 2>& basis, Slope& slope) const {
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  for (const Corner& k : corners_) {
    const Eigen::Vector3d from_b = p - k.b, from_c = p - k.c;
    const double determinant = from_b.dot(k.normal);
    const double stretch = (k.cot_a * (k.c - k.b).squaredNorm() + k.cot_c * from_b.squaredNorm() +
                            k.cot_b * from_c.squaredNorm()) /
                           2.0;
    const double ratio = sphere_area * sphere_area * k.area / (determinant * determinant);
    const Eigen::Vector3d rise = k.cot_c * from_b + k.cot_b * from_c;
    const double first = -2.0 * ratio / determinant;
    gradient += rise * (1.0 + ratio) + k.normal * (stretch * first);
    const Eigen::Matrix3d mixed = rise * k.normal.transpose();
    hessian += first * (mixed + mixed.transpose());
    hessian +=
        6.0 * stretch * ratio / (determinant * determinant) * k.normal * k.normal.transpose();
    hessian.diagonal().array() += (k.cot_b + k.cot_c) * (1.0 + ratio);
  }
  slope.gradient += sphere_weight * basis.transpose() * gradient;
  slope.hessian += sphere_weight * basis.transpose() * hessian * basis;
  slope.hessian.diagonal().array() -= sphere_weight * p.dot(gradient);  // the sphere bends away
}

double ComposedMap::energy_at(VertexIndex v, const Eigen::Vector3d& p, const Image& image) const {
  const double misfit =
      own_area_ > 0.0
          ? static_cast<double>((own_signal(v) - image.signal).cwiseAbs2().dot(weights_))
          : 0.0;
  const double astray =
      led_weights_.empty() ? 0.0 : led_weights_[v] * (image.position - led_[v]).squaredNorm();
  return distortion_weight_ * distortion_energy(image.position) + own_area_ * (misfit + astray) +
         sphere_energy(p);
}

ComposedMap::Slope ComposedMap::slope_at(VertexIndex v, const Eigen::Vector3d& p,
                                         const Eigen::Matrix<double, 3, 2>& basis) const {
  const Image& image = images_[v];
  const Triangle& face = target_.closed.topology->faces()[image.place.face];
  Eigen::Matrix3d corners, places;
  for (Eigen::Index k = 0; k < 3; ++k) {
    corners.col(k) = target_.sphere[face[static_cast<std::size_t>(k)]];
    places.col(k) = target_.signals.positions[face[static_cast<std::size_t>(k)]];
  }
  // Weights are the coordinates in the corners over their sum.
  const Eigen::Matrix3d inverse = corners.inverse();
  const double sum = (inverse * p).sum();
  Eigen::Matrix<double, 3, 2> weights = inverse * basis / sum;
  const Eigen::RowVector2d total = weights.colwise().sum();
  for (Eigen::Index k = 0; k < 3; ++k)
    weights.row(k) -= image.place.weights[static_cast<std::size_t>(k)] * total;
  const Eigen::Matrix<double, 3, 2> moves = places * weights;

  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  for (const Corner& k : corners_) {
    const Eigen::Vector3d from_b = image.position - k.image_b, from_c = image.position - k.image_c;
    const Eigen::Vector3d cross = from_b.cross(from_c);
    const double doubled = std::sqrt(cross.squaredNorm() + least_area * k.area);
    const Eigen::Vector3d rise = (k.image_c - k.image_b).cross(cross) / -doubled;  // of `doubled`
    const double stretch = (k.cot_a * (k.image_c - k.image_b).squaredNorm() +
                            k.cot_c * from_b.squaredNorm() + k.cot_b * from_c.squaredNorm()) /
                           2.0;
    const double ratio = k.area / (doubled * doubled), scale = k.weight / 4.0;
    const Eigen::Vector3d slope = k.cot_c * from_b + k.cot_b * from_c;
    const double first = -2.0 * ratio / doubled;
    gradient += scale * (slope * (1.0 + ratio) + rise * (stretch * first));
    const Eigen::Matrix3d mixed = slope * rise.transpose();
    hessian += scale * first * (mixed + mixed.transpose());
    hessian += scale * 6.0 * stretch * ratio / (doubled * doubled) * rise * rise.transpose();
    hessian.diagonal().array() += scale * (k.cot_b + k.cot_c) * (1.0 + ratio);
  }
  Slope result{moves.transpose() * gradient * distortion_weight_,
               moves.transpose() * hessian * moves * distortion_weight_};
  if (!led_weights_.empty()) {
    const double pull = 2.0 * own_area_ * led_weights_[v];
    result.gradient += pull * moves.transpose() * (image.position - led_[v]);
    result.hessian += pull * moves.transpose() * moves;
  }
  if (own_area_ > 0.0) {
    Eigen::Matrix<float, channels, 2> rates = Eigen::Matrix<float, channels, 2>::Zero();
    for (Eigen::Index k = 0; k < 3; ++k) {
      rates += (*rest_values_)[face[static_cast<std::size_t>(k)]] * weights.row(k).cast<float>();
    }
    const Eigen::Matrix<float, channels, 2> weighed = weights_.asDiagonal() * rates;
    result.gradient -=
        2.0 * own_area_ * (weighed.transpose() * (own_signal(v) - image.signal)).cast<double>();
    result.hessian += 2.0 * own_area_ * (weighed.transpose() * rates).cast<double>();
  }
  return result;
}

double ComposedMap::descend(VertexIndex v) {
  if (held_[v] != 0) return 0.0;
  gather(v);
  const Eigen::Vector3d start = sphere_[v];
  const double before = energy_at(v, sphere_[v], images_[v]);
  const Eigen::Matrix<double, 3, 2> basis = spherical::tangent_basis(start);
  Slope slope = slope_at(v, start, basis);
  add_sphere_slope(start, basis, slope);
  const Eigen::Vector2d direction = spherical::newton_direction(slope.gradient, slope.hessian);
  const double promised = -slope.gradient.dot(direction);
  if (!(promised > 1e-7 * before) || !direction.allFinite()) return 0.0;
  double step = std::min(1.0, 0.3 / direction.norm());
  for (int attempt = 0; attempt < 8; ++attempt, step *= 0.5) {
    const Eigen::Vector3d p = (start + basis * (direction * step)).normalized();
    if (!in_place(p)) continue;
    const Image image = image_of(p, images_[v].place.face);
    const double after = energy_at(v, p, image);
    if (after < before) {
      sphere_[v] = p;
      images_[v] = image;
      return before - after;
    }
  }
  return 0.0;
}

double ComposedMap::sweep() {
  double fallen = 0.0;
  for (const VertexIndex v : mesh_.alive()) fallen += descend(v);
  return fallen;
}

double ComposedMap::energy() {
  double sum = 0.0;
  for (const VertexIndex v : mesh_.alive()) {
    gather(v);
    sum += energy_at(v, sphere_[v], images_[v]);
  }
  return sum;
}

double ComposedMap::distortion_at(VertexIndex v) {
  gather(v);
  double area = 0.0;
  for (const Corner& k : corners_) area += k.weight * std::sqrt(k.area) / 2.0;
  return distortion_energy(images_[v].position) / area;
}

}  // namespace kinemesh::full_matching
