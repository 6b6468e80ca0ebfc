#include "report/html/animation_code.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "config/error.h"
#include "config/parallel.h"
#include "mesh/pca/pca.h"

namespace kinemesh {
namespace {

constexpr double levels = 32767.0;
constexpr std::size_t learning_frames = 500;

void check_finite(const AnimatedMesh& animation) {
  const auto positions = animation.positions();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (std::isfinite(positions[i])) continue;
    const std::size_t frame = i / (3 * animation.vertex_count());
    throw InputError({.what = "vertex " + std::to_string(i / 3 % animation.vertex_count()) +
                              " has no finite position",
                      .frame = animation.first_frame + static_cast<int64_t>(frame),
                      .remedy = "Fill the gaps before the animation is put into a page"});
  }
}

// From evenly spaced frames where the mesh is large: the modes of a take show in a few hundred of
// its frames. Small meshes are learned from every frame.
PcaResult modes_of(const AnimatedMesh& animation, std::size_t most, const RunContext& ctx) {
  PcaOptions options;
  options.modes = static_cast<int>(std::max<std::size_t>(most, 1));
  const std::size_t frames = animation.frame_count();
  if (frames <= learning_frames || 3 * animation.vertex_count() <= 800) {
    return pca_of(animation, options, ctx);
  }
  AnimatedMesh some(animation.shared_topology(), learning_frames, animation.rate_hz);
  for (std::size_t i = 0; i < learning_frames; ++i) {
    some.frame(i) = animation.frame(i * (frames - 1) / (learning_frames - 1));
  }
  return pca_of(some, options, ctx);
}

// Modes and scores as the page will hold them: whole numbers within ±32767, as floats.
struct Coded {
  Eigen::VectorXf mean;
  Eigen::MatrixXf modes;   // 3V × K
  Eigen::MatrixXf scores;  // K × keys
  std::vector<double> scales;
  double spacing = 1.0;  // frames from key to key
};

float quantise(Eigen::Ref<Eigen::VectorXf> values) {
  const float most = values.size() > 0 ? values.cwiseAbs().maxCoeff() : 0.0F;
  if (!(most > 0.0F)) return 0.0F;
  const float scale = most / static_cast<float>(levels);
  for (float& v : values) v = std::round(v / scale);
  return scale;
}

std::size_t key_count(std::size_t frames, std::size_t step) {
  return (frames - 1 + step - 1) / step + 1;
}

// The first and last frames are keys; the others lie evenly between them.
double spacing_of(std::size_t frames, std::size_t keys) {
  return keys > 1 ? static_cast<double>(frames - 1) / static_cast<double>(keys - 1) : 1.0;
}

Coded code_of(const AnimatedMesh& animation, const PcaResult& pca, std::size_t modes,
              std::size_t step, const RunContext& ctx) {
  const auto n = static_cast<Eigen::Index>(3 * animation.vertex_count());
  const auto k = static_cast<Eigen::Index>(modes);
  const std::size_t keys = key_count(animation.frame_count(), step);
  Coded coded{pca.mean, pca.modes.leftCols(k), {}, {}, spacing_of(animation.frame_count(), keys)};
  coded.scores.resize(k, static_cast<Eigen::Index>(keys));
  parallel_for(ctx, keys, 64, [&](std::size_t key) {
    const double at = static_cast<double>(key) * coded.spacing;
    const auto before = std::min(static_cast<std::size_t>(at), animation.frame_count() - 1);
    const std::size_t after = std::min(before + 1, animation.frame_count() - 1);
    const auto t = static_cast<float>(at - static_cast<double>(before));
    const auto frame = [&](std::size_t f) {
      return Eigen::Map<const Eigen::VectorXf>(
          animation.positions().data() + f * static_cast<std::size_t>(n), n);
    };
    const Eigen::VectorXf x = frame(before) * (1.0F - t) + frame(after) * t;
    coded.scores.col(static_cast<Eigen::Index>(key)) = coded.modes.transpose() * (x - coded.mean);
  });
  for (Eigen::Index i = 0; i < k; ++i) {
    const float mode_scale = quantise(coded.modes.col(i));
    Eigen::VectorXf row = coded.scores.row(i);
    const float score_scale = quantise(row);
    coded.scores.row(i) = row;
    coded.scales.push_back(static_cast<double>(mode_scale) * score_scale);
  }
  return coded;
}

struct Between {
  Eigen::Index before, after;
  float t;
};
Between between(std::size_t frame, double spacing, std::size_t keys) {
  const double at = static_cast<double>(frame) / spacing;
  const auto last = static_cast<Eigen::Index>(keys) - 1;
  const auto before = std::min(static_cast<Eigen::Index>(at), std::max<Eigen::Index>(last - 1, 0));
  return {
      before, std::min(before + 1, last),
      static_cast<float>(std::min(at, static_cast<double>(last)) - static_cast<double>(before))};
}

Eigen::VectorXf decode(const Coded& coded, std::size_t frame) {
  const auto [before, after, t] =
      between(frame, coded.spacing, static_cast<std::size_t>(coded.scores.cols()));
  Eigen::VectorXf weights = coded.scores.col(before) * (1.0F - t) + coded.scores.col(after) * t;
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    weights[i] *= static_cast<float>(coded.scales[static_cast<std::size_t>(i)]);
  }
  return coded.mean + coded.modes * weights;
}

struct Error2 {
  double largest = 0.0, sum = 0.0;  // squared, mm²
};

Error2 error_of(const AnimatedMesh& animation, const Coded& coded, const RunContext& ctx) {
  constexpr std::size_t grain = 64;
  const std::size_t n = 3 * animation.vertex_count();
  std::vector<Error2> parts((animation.frame_count() + grain - 1) / grain);
  parallel_chunks(ctx, animation.frame_count(), grain, [&](std::size_t begin, std::size_t end) {
    Error2& part = parts[begin / grain];
    for (std::size_t f = begin; f < end; ++f) {
      const Eigen::VectorXf decoded = decode(coded, f);
      const float* x = animation.positions().data() + f * n;
      for (std::size_t i = 0; i < n; i += 3) {
        double squared = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
          const double d =
              static_cast<double>(x[i + c]) - decoded[static_cast<Eigen::Index>(i + c)];
          squared += d * d;
        }
        part.largest = std::max(part.largest, squared);
        part.sum += squared;
      }
    }
  });
  Error2 total;
  for (const Error2& part : parts) {
    total.largest = std::max(total.largest, part.largest);
    total.sum += part.sum;
  }
  return total;
}

template <class T>
void append(std::string& bytes, const T* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

template <class Matrix>
void append_words(std::string& bytes, const Matrix& values) {
  std::vector<int16_t> words(static_cast<std::size_t>(values.size()));
  std::transform(values.data(), values.data() + values.size(), words.begin(),
                 [](float v) { return static_cast<int16_t>(v); });
  append(bytes, words.data(), words.size());
}

// The search for the number of modes and the distance of the keys.
class Encoder {
 public:
  Encoder(const AnimatedMesh& animation, const AnimationCodeOptions& options, const RunContext& ctx)
      : animation_(animation), options_(options), ctx_(ctx) {
    const std::size_t fixed = 12 * animation.vertex_count();
    if (options.max_bytes < fixed) {
      throw NoResultError({.what = "a mesh of " + std::to_string(animation.vertex_count()) +
                                   " vertices does not fit into " +
                                   std::to_string(options.max_bytes) + " bytes",
                           .remedy = "Allow a larger page or simplify the mesh"});
    }
    room_ = options.max_bytes - fixed;
    const std::size_t most =
        std::min({options.max_modes, animation.frame_count(), 3 * animation.vertex_count(),
                  modes_that_fit(longest_step())});
    if (most > 0) pca_ = modes_of(animation, most, ctx);
  }

  AnimationCode run() {
    AnimationCode best = best_within(1);
    // Keys farther apart leave room for more modes: worth it where scores take most of the room.
    for (std::size_t step = 2; step <= longest_step(); step *= 2) {
      if (best.max_error_mm <= options_.max_error_mm) break;
      AnimationCode other = best_within(step);
      if (other.rms_error_mm < best.rms_error_mm) best = std::move(other);
    }
    return best;
  }

 private:
  std::size_t longest_step() const {
    std::size_t step = 1;
    while (step < 16 &&
           2 * key_count(animation_.frame_count(), step) > 6 * animation_.vertex_count()) {
      step *= 2;
    }
    return step;
  }
  std::size_t modes_that_fit(std::size_t step) const {
    return room_ / (6 * animation_.vertex_count() + 2 * key_count(animation_.frame_count(), step));
  }

  // The fewest modes that reach the error asked for, or as many as fit.
  AnimationCode best_within(std::size_t step) {
    const auto found = static_cast<std::size_t>(pca_.modes.cols());
    std::size_t high = std::min(found, modes_that_fit(step));
    AnimationCode best = encode(high, step);
    std::size_t low = 0;
    while (best.max_error_mm <= options_.max_error_mm && low + 1 < high) {
      const std::size_t middle = (low + high) / 2;
      AnimationCode smaller = encode(middle, step);
      if (smaller.max_error_mm <= options_.max_error_mm) {
        best = std::move(smaller);
        high = middle;
      } else {
        low = middle;
      }
    }
    return best;
  }

  AnimationCode encode(std::size_t modes, std::size_t step) {
    if (pca_.mean.size() == 0) take_mean();
    const Coded coded = code_of(animation_, pca_, modes, step, ctx_);
    const Error2 error = error_of(animation_, coded, ctx_);
    AnimationCode code;
    code.scales = coded.scales;
    code.keys = static_cast<std::size_t>(coded.scores.cols());
    code.key_step = coded.spacing;
    code.max_error_mm = std::sqrt(error.largest);
    code.rms_error_mm = std::sqrt(
        error.sum / static_cast<double>(animation_.frame_count() * animation_.vertex_count()));
    append(code.bytes, coded.mean.data(), static_cast<std::size_t>(coded.mean.size()));
    append_words(code.bytes, coded.modes);
    append_words(code.bytes, coded.scores);
    return code;
  }

  // When there is no room for modes: the shape alone.
  void take_mean() {
    const auto n = static_cast<Eigen::Index>(3 * animation_.vertex_count());
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
    for (std::size_t f = 0; f < animation_.frame_count(); ++f) {
      sum += Eigen::Map<const Eigen::VectorXf>(
                 animation_.positions().data() + f * static_cast<std::size_t>(n), n)
                 .cast<double>();
    }
    pca_.mean = (sum / static_cast<double>(animation_.frame_count())).cast<float>();
    pca_.modes.resize(n, 0);
  }

  const AnimatedMesh& animation_;
  const AnimationCodeOptions& options_;
  const RunContext& ctx_;
  std::size_t room_ = 0;
  PcaResult pca_;
};

}  // namespace

AnimationCode encode_animation(const AnimatedMesh& animation, const AnimationCodeOptions& options,
                               const RunContext& ctx) {
  if (animation.frame_count() == 0 || animation.vertex_count() == 0) {
    throw NoResultError({.what = "the mesh has no frames or no vertices"});
  }
  check_finite(animation);
  return Encoder(animation, options, ctx).run();
}

std::vector<float> decode_frame(const AnimationCode& code, std::size_t vertex_count,
                                std::size_t frame) {
  const std::size_t n = 3 * vertex_count;
  const std::size_t k = code.scales.size();
  std::vector<float> mean(n);
  std::vector<int16_t> modes(n * k);
  std::vector<int16_t> scores(code.keys * k);
  const char* at = code.bytes.data();
  std::memcpy(mean.data(), at, 4 * n);
  std::memcpy(modes.data(), at + 4 * n, 2 * modes.size());
  std::memcpy(scores.data(), at + 4 * n + 2 * modes.size(), 2 * scores.size());
  const auto [before, after, t] = between(frame, code.key_step, code.keys);
  for (std::size_t m = 0; m < k; ++m) {
    const double a = scores[static_cast<std::size_t>(before) * k + m];
    const double b = scores[static_cast<std::size_t>(after) * k + m];
    const double weight = (a + static_cast<double>(t) * (b - a)) * code.scales[m];
    for (std::size_t i = 0; i < n; ++i) {
      mean[i] += static_cast<float>(weight * modes[m * n + i]);
    }
  }
  return mean;
}

}  // namespace kinemesh
