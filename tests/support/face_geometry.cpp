#include "tests/support/face_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace kinemesh::test {

namespace {

constexpr double mouth_v = -34, mouth_half = 26;
constexpr double eye_u = 30, eye_half = 14, eye_v = 32;

double square(double x) { return x * x; }
double above(double x, double from) { return std::max(0.0, x - from); }
double step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}
double bell(double x, double width) { return std::exp(-0.5 * square(x / width)); }
double bell(double u, double v, double cu, double cv, double su, double sv) {
  return std::exp(-0.5 * (square((u - cu) / su) + square((v - cv) / sv)));
}
/// The same bump on both sides of the face.
double both(double u, double v, double cu, double cv, double su, double sv) {
  return bell(u, v, cu, cv, su, sv) + bell(u, v, -cu, cv, su, sv);
}
/// How far the sides of a slit part along it: 1 in the middle, 0 at and beyond its ends.
/// Away from the slit (`distance`, mm) the effect spreads and its ends become smooth.
double aperture(double u, double centre, double half, double distance) {
  const double x = square((u - centre) / (half + 0.8 * distance));
  return x >= 1 ? 0.0 : std::pow(1 - x, 0.6 + distance / 8);
}

/// What skin carries with it when it slides: nose, lips, philtrum.
double skin_relief(const FaceShape& s, double u, double v) {
  const double tip = -8 * s.nose_length;
  double ridge = 0;
  if (v > tip) {
    ridge = std::pow(std::max(0.0, (42 - v) / (42 - tip)), 1.25);
  } else {
    ridge = 1 - step((tip - v) / 13);
  }
  const double along = std::clamp((42 - v) / (42 - tip), 0.0, 1.0);
  const double width = s.nose_width * (6.0 + 3.0 * along);
  double relief = 21 * ridge * std::exp(-std::pow(std::abs(u) / width, 2.2) / 1.6);
  relief += 5.5 * both(u, v, 12 * s.nose_width, -8 * s.nose_length, 4.5, 5.5);
  const double lips = bell(u, 19) * aperture(u, 0, 28, 8);
  relief +=
      s.lip_fullness * lips * (4.2 * bell(v - mouth_v - 5.5, 4.5) + 5.0 * bell(v - mouth_v + 6, 5));
  relief -= 2.0 * lips * bell(v - mouth_v, 2.5);
  relief -= 1.0 * bell(u, v, 0, -22, 3, 5);
  return relief;
}

/// What stays with the bone while skin slides over it.
double bone_relief(const FaceShape& s, double u, double v) {
  double relief = 4.5 * s.brow * both(u, v, 24, 46, 17, 7);
  relief -= 7.0 * s.socket * both(u, v, eye_u, 33, 14, 10);
  relief -= 4.0 * both(u, v, 15, 33, 6, 8);
  relief += 5.0 * both(u, v, eye_u, 32, 9, 7);
  relief += 7.0 * s.cheek * both(u, v, 45, 3, 18, 16);
  relief -= 4.0 * bell(u, v, 0, -51, 17, 5);
  relief += 8.0 * s.chin * bell(u, v, 0, -66, 15, 10);
  relief -= 3.5 * both(u, v, 86, 36, 16, 20);
  relief += 5.0 * s.jaw_width * both(u, v, 78, -42, 16, 18);
  relief += 3.0 * bell(u, v, 0, mouth_v, 26, 20);
  return relief;
}

/// Proportions: moves a domain point to where the subject has that feature.
Eigen::Vector2d own_place(const FaceShape& s, double u, double v) {
  const double mouth = (s.mouth_width - 1) * bell(v - mouth_v, 18) * bell(u, 45);
  const double eyes = (s.eye_distance - 1) * bell(v - eye_v, 16) * bell(u, 55);
  const double lids =
      (s.eye_width - 1) * 14 *
      (bell(u, v, eye_u + 14, eye_v, 8, 10) - bell(u, v, -eye_u - 14, eye_v, 8, 10));
  const double lower = (s.lower_face - 1) * above(10, v) * step((10 - v) / 30);
  return {u * (1 + mouth + eyes) + lids + 0.5 * s.asymmetry * bell(v + 30, 40),
          v - lower + 0.3 * s.asymmetry * u / 40 * bell(u, 60)};
}

/// The head below the features: tapered to the chin, turning back under it and at the forehead.
Eigen::Vector3d head(const FaceShape& s, double u, double v) {
  const double theta = u / 76;
  const double jaw = square(above(20, v) / 115);
  const double x_scale =
      1 - 0.20 * square(above(v, 30) / 65) - (0.42 - 0.15 * (s.jaw_width - 1)) * jaw;
  const double z_scale =
      1 - 0.20 * square(above(v, 22) / 74) - 0.28 * square(above(-62, v) / 34) + 0.02 * jaw;
  const double y = v + 0.36 * square(above(-62, v)) / 34;
  const double front = std::cos(theta);
  // A face is flatter than an ellipse between the eyes and fuller at the cheeks.
  const double bow = 1 + 0.05 * bell(std::abs(u) - 45, 22);
  return {78 * s.width * x_scale * std::sin(theta), s.height * y,
          s.depth * (96 * z_scale * front * bow + 0.10 * std::min(0.0, v + 20) * (1 - front))};
}

Eigen::Vector3d outward(double u) {
  const double theta = u / 76;
  return Eigen::Vector3d(0.75 * std::sin(theta), 0, std::cos(theta)).normalized();
}

struct Weights {
  const ExpressionWeights& w;
  double strength;
  double operator()(Expression e) const { return strength * w[e]; }
};

/// Skin that slides in the domain because lids move; lids never pass each other.
double lid_slide(const Weights& w, double u, double v, int side, double centre, Expression blink) {
  const double part = aperture(u, centre, eye_half, std::abs(v - eye_v));
  if (part == 0) return 0;
  const double shut = std::clamp(w.w[blink], 0.0, 1.0);
  const double meeting = -1.5;
  if (side > 0) {
    const double open = 6.5 + 3.0 * w(Expression::eyes_wide);
    return part * bell(v - eye_v, 7.5) * ((1 - shut) * open + shut * meeting);
  }
  const double open = -2.5 - 0.5 * w(Expression::eyes_wide);
  return part * bell(v - eye_v, 6) * ((1 - shut) * open + shut * meeting);
}

/// Skin sliding along the face: smile, pucker, brows, lips and lids.
Eigen::Vector2d slide(const Weights& w, double u, double v, int side) {
  using enum Expression;
  Eigen::Vector2d d = Eigen::Vector2d::Zero();
  const auto smile = [&](Expression which, double sign) {
    const double corner = bell(u, v, sign * 28, mouth_v, 15, 15);
    d += w(which) * corner * Eigen::Vector2d(sign * 7.5, 7.0);
    d.y() += w(which) * 3.5 * bell(u, v, sign * 40, -4, 16, 14);
  };
  smile(smile_left, 1);
  smile(smile_right, -1);
  d.x() -= w(pucker) * 0.42 * u * bell(u, v, 0, mouth_v, 22, 15);
  d.y() -= w(pucker) * 0.12 * (v - mouth_v) * bell(u, v, 0, mouth_v, 22, 15);
  d.y() += w(brow_raise_left) * 8.0 * bell(u, v, 28, 52, 20, 13);
  d.y() += w(brow_raise_right) * 8.0 * bell(u, v, -28, 52, 20, 13);
  d.x() += w(frown) * 4.5 * (bell(u, v, -18, 47, 10, 9) - bell(u, v, 18, 47, 10, 9));
  d.y() -= w(frown) * 4.0 * both(u, v, 18, 47, 10, 9);
  d.y() += w(nose_wrinkle) * 3.0 * both(u, v, 9, 6, 8, 9);
  d.y() += w(nose_wrinkle) * 2.0 * bell(u, v, 0, -24, 20, 7);
  const double lips = aperture(u, 0, mouth_half, std::abs(v - mouth_v));
  if (v < 0 && lips > 0) {
    d.y() +=
        w(lips_part) * lips * side * (side > 0 ? 3.0 : 3.5) * bell(v - mouth_v, side > 0 ? 8 : 9);
  }
  if (v > 0) {
    d.y() += lid_slide(w, u, v, side, eye_u, blink_left);
    d.y() += lid_slide(w, u, v, side, -eye_u, blink_right);
  }
  return d;
}

/// Movement towards the front: protruded lips, raised cheeks, puffed cheeks.
double bulge(const Weights& w, double u, double v) {
  using enum Expression;
  double b = w(pucker) * 8.0 * bell(u, v, 0, mouth_v, 15, 11);
  b += w(smile_left) * (4.0 * bell(u, v, 42, 2, 13, 11) - 2.0 * bell(u, v, 28, -34, 10, 10));
  b += w(smile_right) * (4.0 * bell(u, v, -42, 2, 13, 11) - 2.0 * bell(u, v, -28, -34, 10, 10));
  b += w(cheek_puff) * 7.0 * both(u, v, 42, -26, 14, 14);
  b += w(frown) * 1.5 * bell(u, v, 0, 46, 6, 8);
  return b;
}

/// How much of the jaw's rotation a point takes: 1 on the chin, 0 above the mouth; across the
/// lips it jumps, and at the mouth corners it does not.
double jaw_share(double u, double v, int side) {
  const double line = mouth_v + 0.38 * above(std::abs(u), mouth_half);
  const double smooth = step((line + 13 - v) / 42);
  const double lips = aperture(u, 0, mouth_half, std::abs(v - mouth_v));
  if (lips == 0) return smooth;
  return side > 0 ? smooth * (1 - lips * bell(v - mouth_v, 12))
                  : smooth + (1 - smooth) * lips * bell(v - mouth_v, 16);
}

Eigen::Vector3d turn_jaw(const FaceShape& s, const Weights& w, double share,
                         const Eigen::Vector3d& p) {
  using enum Expression;
  const double open = share * w(jaw_open) * 0.34, sideways = share * w(jaw_left) * 0.10;
  if (open == 0 && sideways == 0) return p;
  const Eigen::Vector3d joint(0, 8 * s.height, 8 * s.depth);
  const Eigen::Vector3d forward(0, -2.0 * share * w(jaw_open), 3.0 * share * w(jaw_open));
  return Eigen::AngleAxisd(sideways, Eigen::Vector3d::UnitY()) *
             (Eigen::AngleAxisd(open, Eigen::Vector3d::UnitX()) * (p - joint)) +
         joint + forward;
}

}  // namespace

Eigen::Vector3d face_point(const FaceShape& shape, const Eigen::Vector2d& domain, int side,
                           const ExpressionWeights& weights) {
  const Weights w{weights, shape.strength};
  const double u = domain.x(), v = domain.y();
  const Eigen::Vector2d moved = domain + slide(w, u, v, side);
  const Eigen::Vector2d place = own_place(shape, moved.x(), moved.y());
  const double relief =
      bone_relief(shape, moved.x(), moved.y()) + skin_relief(shape, u, v) + bulge(w, u, v);
  Eigen::Vector3d p = head(shape, place.x(), place.y()) + relief * outward(place.x());
  p.z() += shape.mouth_depth * bell(u, v, 0, mouth_v, 30, 18);
  return turn_jaw(shape, w, jaw_share(u, v, side), p);
}

}  // namespace kinemesh::test
