#include "capture/c3d/lint.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/formats/table_text.h"
#include "capture/gaps.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr double usual_rate_min_hz = 10.0;
constexpr double usual_rate_max_hz = 2000.0;
constexpr double usual_extent_min_mm = 5.0;       // a few markers on a finger
constexpr double usual_extent_max_mm = 100000.0;  // a sports hall
constexpr double coarse_step_mm = 0.5;
constexpr double frozen_s = 1.0;
constexpr int integer_limit = 32767;

class Linter {
 public:
  Linter(const MarkerSequence& take, const C3dLayout* layout, const RunContext& ctx)
      : take_(take), layout_(layout), ctx_(ctx) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      if (take.markers()[m].kind == MarkerKind::marker) bodies_.push_back(m);
    }
  }

  std::vector<C3dFinding> run() {
    check_rate();
    ctx_.check_cancelled();
    check_gaps();
    check_residuals();
    ctx_.check_cancelled();
    check_extent();
    check_integers();
    ctx_.check_cancelled();
    check_frozen();
    check_events();
    check_force_plates();
    return std::move(findings_);
  }

 private:
  void add(std::string_view code, std::string message, std::string place) {
    findings_.push_back(c3d_finding(code, std::move(message), std::move(place)));
  }

  std::string name(std::size_t m) const {
    return qualified_label(take_.markers()[m].subject, take_.markers()[m].label);
  }

  /// "marker A", "markers A, B and 3 more".
  std::string place_of(const std::vector<std::size_t>& markers) const {
    constexpr std::size_t most = 5;
    std::vector<std::string> names;
    for (const std::size_t m : markers) {
      if (names.size() == most && markers.size() > most + 1) {
        return "markers " + join(names, ", ") + " and " + std::to_string(markers.size() - most) +
               " more";
      }
      names.push_back(name(m));
    }
    return (names.size() == 1 ? "marker " : "markers ") + join(names, ", ", " and ");
  }

  void check_rate() {
    if (take_.rate_hz >= usual_rate_min_hz && take_.rate_hz <= usual_rate_max_hz) return;
    if (take_.frame_count() < 2) return;
    add("C3D704", "the frame rate is " + format_number(take_.rate_hz) + " Hz",
        "parameter POINT:RATE");
  }

  void check_gaps() {
    std::vector<std::size_t> never;
    std::vector<std::size_t> rarely;
    if (take_.frame_count() == 0) return;
    for (const std::size_t m : bodies_) {
      const MarkerGaps gaps = find_gaps(take_, m);
      if (gaps.missing == take_.frame_count()) {
        never.push_back(m);
      } else if (2 * gaps.missing > take_.frame_count()) {
        rarely.push_back(m);
      }
    }
    if (!never.empty()) {
      add("C3D701",
          count_of(never.size(), "marker") + " of " + std::to_string(bodies_.size()) +
              (never.size() == 1 ? " has" : " have") + " no position in any frame",
          place_of(never));
    }
    if (!rarely.empty()) {
      add("C3D702",
          count_of(rarely.size(), "marker") + " of " + std::to_string(bodies_.size()) +
              (rarely.size() == 1 ? " is" : " are") + " missing in more than half of the frames",
          place_of(rarely));
    }
  }

  void check_residuals() {
    // Text formats carry none.
    if (layout_ == nullptr) return;
    std::size_t valid = 0;
    for (std::size_t i = 0; i < take_.sample_count(); ++i) {
      if ((take_.flags()[i] & SampleFlag::valid) == 0) continue;
      if (take_.residuals()[i] != 0.0F) return;
      ++valid;
    }
    if (valid > 0 && !bodies_.empty()) {
      add("C3D703", "all " + std::to_string(valid) + " positions have residual 0",
          "parameter POINT:SCALE");
    }
  }

  /// Largest side of the box round all valid markers.
  void check_extent() {
    Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
    Eigen::Vector3f high = -low;
    std::size_t markers = 0;
    for (const std::size_t m : bodies_) {
      bool seen = false;
      for (std::size_t f = 0; f < take_.frame_count(); ++f) {
        if (!take_.valid(f, m)) continue;
        low = low.cwiseMin(take_.position(f, m));
        high = high.cwiseMax(take_.position(f, m));
        seen = true;
      }
      if (seen) ++markers;
    }
    if (markers < 3) return;
    const double extent = (high - low).maxCoeff();
    if (extent >= usual_extent_min_mm && extent <= usual_extent_max_mm) return;
    add("C3D705",
        "the markers lie within " + format_fixed(extent, extent < 1 ? 4 : 1) +
            " mm, read in the unit " + (take_.origin.unit.empty() ? "mm" : take_.origin.unit),
        "parameter POINT:UNITS");
  }

  void check_integers() {
    if (layout_ == nullptr || layout_->storage != Storage::integer) return;
    const double step = std::abs(layout_->scale) * millimetres_per(take_.origin.unit).value_or(1.0);
    std::vector<std::size_t> clipped;
    std::size_t samples = 0;
    for (const std::size_t m : bodies_) {
      std::size_t here = 0;
      for (std::size_t f = 0; f < take_.frame_count(); ++f) {
        if (!take_.valid(f, m)) continue;
        const double largest = take_.position(f, m).cwiseAbs().maxCoeff();
        if (std::round(largest / step) >= integer_limit) ++here;
      }
      if (here > 0) clipped.push_back(m);
      samples += here;
    }
    if (samples > 0) {
      add("C3D706",
          count_of(samples, "position") + " at " + format_fixed(step * integer_limit, 1) +
              " mm, the largest coordinate that the integers can hold",
          place_of(clipped));
    }
    if (step > coarse_step_mm && !bodies_.empty()) {
      add("C3D707", "one integer step is " + format_number(std::round(step * 1e4) / 1e4) + " mm",
          "parameter POINT:SCALE");
    }
  }

  /// Longest run of frames in which the marker has exactly one position.
  std::size_t longest_rest(std::size_t m) const {
    std::size_t longest = 0;
    std::size_t run = 0;
    for (std::size_t f = 0; f < take_.frame_count(); ++f) {
      if (!take_.valid(f, m)) {
        run = 0;
        continue;
      }
      run = run > 0 && take_.position(f, m) == take_.position(f - 1, m) ? run + 1 : 1;
      longest = std::max(longest, run);
    }
    return longest;
  }

  void check_frozen() {
    // Measured floats never repeat; integers may, and what is not measured (residual 0) does.
    if (layout_ == nullptr || layout_->storage != Storage::real || take_.rate_hz <= 0) return;
    const double enough = std::max(10.0, frozen_s * take_.rate_hz);
    std::vector<std::size_t> frozen;
    std::size_t longest = 0;
    for (const std::size_t m : bodies_) {
      const std::size_t rest = longest_rest(m);
      if (static_cast<double>(rest) < enough) continue;
      frozen.push_back(m);
      longest = std::max(longest, rest);
    }
    if (frozen.empty()) return;
    add("C3D708",
        count_of(frozen.size(), "marker") + (frozen.size() == 1 ? " repeats" : " repeat") +
            " exactly one position for up to " +
            format_fixed(static_cast<double>(longest) / take_.rate_hz, 1) + " s",
        place_of(frozen));
  }

  void check_events() {
    for (std::size_t i = 0; i < take_.events.size(); ++i) {
      const auto first = take_.events.begin();
      if (std::find(first, first + static_cast<std::ptrdiff_t>(i), take_.events[i]) ==
          first + static_cast<std::ptrdiff_t>(i)) {
        continue;
      }
      add("C3D709", "it stands twice at " + format_fixed(take_.events[i].time_s, 3) + " s",
          "event " + take_.events[i].label);
      return;
    }
  }

  std::size_t count(const C3dParameter* p) const { return p == nullptr ? 0 : p->numbers.size(); }

  void check_force_plates() {
    const C3dParameter* used = take_.parameters.find("FORCE_PLATFORM", "USED");
    if (used == nullptr || used->numbers.empty() || !(used->numbers[0] > 0)) return;
    const auto plates = static_cast<std::size_t>(used->numbers[0]);
    const auto check = [&](const char* parameter, std::size_t per_plate) {
      const std::size_t have = count(take_.parameters.find("FORCE_PLATFORM", parameter));
      if (have >= plates * per_plate) return;
      add("C3D710",
          "there are values for " + count_of(have / per_plate, "force plate") + ", but " +
              std::to_string(plates) + " are used",
          std::string("parameter FORCE_PLATFORM:") + parameter);
    };
    check("TYPE", 1);
    check("CORNERS", 12);
    check("ORIGIN", 3);
    check("CHANNEL", 6);
    const C3dParameter* channels = take_.parameters.find("FORCE_PLATFORM", "CHANNEL");
    if (channels == nullptr || channels->numbers.empty()) return;
    const double highest = *std::ranges::max_element(channels->numbers);
    if (highest > static_cast<double>(take_.analog.channels.size())) {
      add("C3D711",
          "channel " + format_number(highest) + " is named, but the file has " +
              count_of(take_.analog.channels.size(), "analog channel"),
          "parameter FORCE_PLATFORM:CHANNEL");
    }
  }

  const MarkerSequence& take_;
  const C3dLayout* layout_;
  const RunContext& ctx_;
  std::vector<std::size_t> bodies_;  // points of kind marker
  std::vector<C3dFinding> findings_;
};

}  // namespace

std::vector<C3dFinding> lint_session(const MarkerSequence& take, const C3dLayout* layout,
                                     const RunContext& ctx) {
  return Linter(take, layout, ctx).run();
}

}  // namespace kinemesh
