#include <algorithm>

#include "config/error.h"
#include "tests/support/random.h"
#include "tests/support/synthetic_take.h"

namespace kinemesh::test {

namespace {

/// Minimum-jerk step from 0 to 1.
double rise(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * x * (10 + x * (6 * x - 15));
}

class MotionBuilder {
 public:
  explicit MotionBuilder(std::string name) { motion_.name = std::move(name); }
  MotionBuilder& pulse(std::initializer_list<Expression> expressions, double strength, double onset,
                       double peak, double release, double end) {
    for (const Expression e : expressions) {
      motion_.pulses.push_back({e, strength, onset, peak, release, end});
    }
    return *this;
  }
  MotionBuilder& blink(double at) {
    using enum Expression;
    return pulse({blink_left, blink_right}, 1, at, at + 0.09, at + 0.13, at + 0.30);
  }
  MotionBuilder& main(double onset, double peak) {
    motion_.onset_s = onset;
    motion_.peak_s = peak;
    return *this;
  }
  Motion opening(std::vector<std::string> names) {
    motion_.openings = std::move(names);
    return motion_;
  }

 private:
  Motion motion_;
};

const std::vector<std::string> eyes{"left_eye", "right_eye"};
const std::vector<std::string> all{"mouth", "left_eye", "right_eye"};

Motion happy() {
  using enum Expression;
  return MotionBuilder("happy")
      .pulse({smile_left}, 1.0, 0.80, 1.50, 2.40, 3.10)
      .pulse({smile_right}, 0.93, 0.82, 1.52, 2.40, 3.12)
      .pulse({lips_part}, 0.9, 0.95, 1.50, 2.35, 2.95)
      .pulse({jaw_open}, 0.30, 0.95, 1.50, 2.35, 2.95)
      .blink(0.25)
      .main(0.80, 1.50)
      .opening(all);
}

Motion surprise() {
  using enum Expression;
  return MotionBuilder("surprise")
      .pulse({brow_raise_left}, 1.0, 0.80, 1.20, 2.20, 2.90)
      .pulse({brow_raise_right}, 0.95, 0.80, 1.20, 2.20, 2.90)
      .pulse({eyes_wide}, 1.0, 0.80, 1.15, 2.20, 2.80)
      .pulse({jaw_open}, 0.75, 0.85, 1.30, 2.30, 3.00)
      .blink(0.30)
      .main(0.80, 1.30)
      .opening(all);
}

Motion talk() {
  using enum Expression;
  MotionBuilder builder("talk");
  for (int k = 0; k < 5; ++k) {
    const double at = 0.3 + 0.55 * k, strength = 0.30 + 0.08 * (k % 3);
    builder.pulse({jaw_open}, strength, at, at + 0.15, at + 0.2, at + 0.4);
    builder.pulse({k % 2 == 0 ? pucker : lips_part}, 0.5, at, at + 0.2, at + 0.25, at + 0.5);
  }
  return builder.blink(1.9).main(0.3, 0.45).opening(all);
}

}  // namespace

ExpressionWeights Motion::at(double time_s) const {
  ExpressionWeights weights;
  for (const ExpressionPulse& p : pulses) {
    const double up = rise((time_s - p.onset_s) / (p.peak_s - p.onset_s));
    const double down = rise((time_s - p.release_s) / (p.end_s - p.release_s));
    weights[p.expression] += p.strength * (up - down);
  }
  return weights;
}

Motion vary(const Motion& motion, uint64_t seed) {
  Random random(seed * 32452843 + 19);
  const double delay = random.uniform(-0.15, 0.15), pace = random.uniform(0.92, 1.08);
  const auto shifted = [&](double t) { return std::max(0.02, t * pace + delay); };
  Motion varied = motion;
  varied.onset_s = shifted(motion.onset_s);
  varied.peak_s = shifted(motion.peak_s);
  for (ExpressionPulse& p : varied.pulses) {
    const bool blinks =
        p.expression == Expression::blink_left || p.expression == Expression::blink_right;
    if (!blinks) p.strength *= random.uniform(0.9, 1.1);  // a blink shuts the lids, whoever does it
    const double from = p.onset_s;
    p.onset_s = shifted(from);
    const auto later = [&](double t) { return p.onset_s + (t - from) * pace; };
    p.peak_s = later(p.peak_s);
    p.release_s = later(p.release_s);
    p.end_s = later(p.end_s);
  }
  return varied;
}

Motion make_motion(MotionKind kind) {
  using enum Expression;
  switch (kind) {
    case MotionKind::happy: return happy();
    case MotionKind::surprise: return surprise();
    case MotionKind::talk: return talk();
    case MotionKind::jaw:
      return MotionBuilder("jaw")
          .pulse({jaw_open}, 0.9, 0.6, 1.3, 1.9, 2.6)
          .pulse({jaw_left}, 0.5, 1.2, 1.6, 2.0, 2.5)
          .main(0.6, 1.3)
          .opening({"mouth"});
    case MotionKind::brows:
      return MotionBuilder("brows")
          .pulse({brow_raise_left, brow_raise_right}, 1, 0.5, 1.0, 1.3, 1.8)
          .pulse({frown}, 1, 1.9, 2.3, 2.6, 3.2)
          .main(0.5, 1.0)
          .opening({});
    case MotionKind::blinks:
      return MotionBuilder("blinks").blink(0.8).blink(2.1).main(0.8, 0.89).opening(eyes);
    case MotionKind::pucker:
      return MotionBuilder("pucker")
          .pulse({pucker}, 1, 0.7, 1.2, 1.9, 2.5)
          .main(0.7, 1.2)
          .opening({});
    case MotionKind::pucker_jaw:
      return MotionBuilder("pucker_jaw")
          .pulse({pucker}, 0.9, 0.4, 0.9, 1.2, 1.7)
          .pulse({jaw_open}, 0.6, 1.8, 2.2, 2.5, 3.0)
          .main(0.4, 0.9)
          .opening({"mouth"});
    case MotionKind::puff:
      return MotionBuilder("puff")
          .pulse({cheek_puff}, 1, 0.4, 0.8, 1.2, 1.6)
          .pulse({nose_wrinkle}, 1, 1.5, 1.9, 2.1, 2.5)
          .pulse({smile_left, smile_right}, 0.8, 2.3, 2.7, 2.9, 3.4)
          .main(0.4, 0.8)
          .opening({});
  }
  throw InternalError("no such motion");
}

}  // namespace kinemesh::test
