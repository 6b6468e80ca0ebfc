// merge-subjects, anonymise, add-event, units, axes: what the take says about itself.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>

#include "capture/c3d/parameter_access.h"
#include "capture/c3d/point_table.h"
#include "capture/edit/anonymise.h"
#include "capture/edit/operation.h"
#include "capture/rotation_data.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

class MergeSubjects : public EditOperation {
 public:
  std::string_view name() const override { return "merge-subjects"; }
  void declare(ParameterSet& p) override {
    p.list("subjects", subjects_, {.metavar = "NAME", .help = "to be merged; empty: all"});
    p.text("into", into_, {.metavar = "NAME", .help = "the subject they become"});
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    if (into_.empty()) throw UsageError({.what = "'into' names the subject, and is missing"});
    std::vector<std::pair<std::string, std::string>> names;
    for (const Marker& m : take.markers()) {
      const bool wanted = subjects_.empty() || std::ranges::count(subjects_, m.subject) > 0;
      if (wanted) names.emplace_back(m.subject, into_);
    }
    for (const std::string& subject : subjects_) {
      const bool known = std::ranges::any_of(take.markers(),
                                             [&](const Marker& m) { return m.subject == subject; });
      if (!known) {
        throw UsageError({.what = "no marker belongs to a subject '" + subject + "'",
                          .remedy = "See the subjects with \"kinemesh c3d info\""});
      }
    }
    refuse_twins(take, names);
    rename_subjects(take, names);
    return "merged " + (subjects_.empty() ? "all subjects" : join(subjects_, ", ", " and ")) +
           " into " + into_;
  }

 private:
  void refuse_twins(const MarkerSequence& take,
                    const std::vector<std::pair<std::string, std::string>>& names) const {
    std::vector<std::string> labels;
    for (const Marker& m : take.markers()) {
      const bool merged = m.subject == into_ || std::ranges::any_of(names, [&](const auto& n) {
                            return n.first == m.subject;
                          });
      if (!merged) continue;
      if (std::ranges::count(labels, m.label) > 0) {
        throw UsageError({.what = "two of the subjects have a marker '" + m.label + "'",
                          .marker = m.label,
                          .remedy = "Rename one of the two first"});
      }
      labels.push_back(m.label);
    }
  }

  std::vector<std::string> subjects_;
  std::string into_;
};

class Anonymise : public EditOperation {
 public:
  std::string_view name() const override { return "anonymise"; }
  void declare(ParameterSet& p) override { (void)p; }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    return "replaced " + count_of(anonymise_take(take), "subject's name", "subjects' names") +
           " and dropped what describes persons and files";
  }
};

class AddEvent : public EditOperation {
 public:
  std::string_view name() const override { return "add-event"; }
  void declare(ParameterSet& p) override {
    p.text("label", event_.label, {.metavar = "TEXT", .help = "what happens"});
    p.number("frame", frame_,
             {.min = 0, .max = 4e9, .help = "frame at which it happens; 0 to give a time"});
    p.number("time", event_.time_s,
             {.unit = "s",
              .min = no_time_s,
              .max = 1e9,
              .help = "since recorded frame 1; this or a frame must be given"});
    p.text("context", event_.context, {.metavar = "TEXT", .help = "Left, Right, General"});
    p.text("subject", event_.subject, {.metavar = "NAME", .help = "whose event it is"});
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    if (event_.label.empty()) throw UsageError({.what = "'label' names the event, and is missing"});
    const bool timed = event_.time_s > no_time_s;
    if (timed == (frame_ > 0)) {
      throw UsageError({.what = timed
                                    ? "'frame' and 'time' both say when the event is"
                                    : "'frame' or 'time' says when the event is; both are missing",
                        .remedy = "Give one of the two"});
    }
    Event event = event_;
    if (frame_ > 0) {
      frames_between(take, frame_, frame_);
      if (!(take.rate_hz > 0.0)) throw UsageError({.what = "the take has no frame rate"});
      event.time_s = static_cast<double>(frame_ - 1) / take.rate_hz;
    }
    refuse_outside(take, event.time_s);
    take.events.push_back(event);
    std::ranges::stable_sort(take.events, {}, &Event::time_s);
    return "added event " + event.label + " at " + format_fixed(event.time_s, 3) + " s";
  }

 private:
  static void refuse_outside(const MarkerSequence& take, double time_s) {
    if (!(take.rate_hz > 0.0) || take.frame_count() == 0) return;
    const double first = static_cast<double>(take.first_frame - 1) / take.rate_hz;
    const double last = first + static_cast<double>(take.frame_count() - 1) / take.rate_hz;
    const double slack = 0.5 / take.rate_hz;
    if (time_s >= first - slack && time_s <= last + slack) return;
    throw UsageError({.what = "the event at " + format_fixed(time_s, 3) +
                              " s lies outside the take, which lasts from " +
                              format_fixed(first, 3) + " to " + format_fixed(last, 3) + " s",
                      .remedy = "Give a 'time' within it, counted from recorded frame 1, or a "
                                "'frame'"});
  }

  static constexpr double no_time_s = -1e9;
  Event event_{.time_s = no_time_s};
  int64_t frame_ = 0;
};

class Units : public EditOperation {
 public:
  std::string_view name() const override { return "units"; }
  void declare(ParameterSet& p) override {
    p.text("unit", unit_, {.metavar = "UNIT", .help = "mm, cm or m: how lengths are written"});
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    const bool offered = unit_ == "mm" || unit_ == "cm" || unit_ == "m";
    const auto now = offered ? millimetres_in(unit_) : std::nullopt;
    if (!now) throw UsageError({.what = "'" + unit_ + "' is no unit of length: mm, cm or m"});
    const double before = millimetres_in(take.origin.unit).value_or(1.0);
    take.origin.scale *= before / *now;  // the same step in the other unit
    scale_rotations(take.rotations, before / *now);
    scale_force_plates(take.parameters, before / *now);
    const std::string old = take.origin.unit;
    take.origin.unit = unit_;
    return "lengths are written in " + unit_ + " instead of " + old;
  }

 private:
  std::string unit_ = "mm";
};

enum class Up { automatic, y, z };

class Axes : public EditOperation {
 public:
  std::string_view name() const override { return "axes"; }
  void declare(ParameterSet& p) override {
    p.choice("preset", preset_,
             {{Up::y, "y-up", "x right, y up, z towards the viewer"},
              {Up::z, "z-up", "x right, z up, y away from the viewer"}},
             "how the axes lie afterwards");
    p.choice("from", from_,
             {{Up::automatic, "auto", "as the file says (POINT:X_SCREEN and Y_SCREEN)"},
              {Up::y, "y-up", "y is up"},
              {Up::z, "z-up", "z is up"}},
             "how they lie now");
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    const Screen now = screen_of(take);
    const bool to_y = preset_ == Up::y;
    const Screen then = {Eigen::Vector3d::UnitX(),
                         to_y ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ()};
    take.origin.x_screen = "+X";
    take.origin.y_screen = to_y ? "+Y" : "+Z";
    const Eigen::Matrix3d whole = then.axes() * now.axes().transpose();
    if (whole.isIdentity()) return "the axes already were as asked for";
    const auto turn = [&whole](auto& x, auto& y, auto& z) {
      const Eigen::Vector3d turned = whole * Eigen::Vector3d(x, y, z);
      x = static_cast<std::remove_reference_t<decltype(x)>>(turned.x());
      y = static_cast<std::remove_reference_t<decltype(y)>>(turned.y());
      z = static_cast<std::remove_reference_t<decltype(z)>>(turned.z());
    };
    const std::span<float> p = take.positions();
    for (std::size_t i = 0; i < take.sample_count(); ++i) {
      if (take.markers()[i % take.marker_count()].kind > MarkerKind::virtual_point) continue;
      turn(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
    }
    for (Eigen::Vector3f& q : take.unlabelled.positions) turn(q.x(), q.y(), q.z());
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      move_rotations(take.rotations, f, whole, Eigen::Vector3d::Zero());
    }
    if (C3dParameter* corners = take.parameters.find("FORCE_PLATFORM", "CORNERS")) {
      std::vector<double>& n = corners->numbers;
      for (std::size_t i = 0; i + 2 < n.size(); i += 3) turn(n[i], n[i + 1], n[i + 2]);
    }
    return std::string("turned the axes so that x points right and ") + (to_y ? "y" : "z") + " up";
  }

 private:
  /// What points right and up on the screen.
  struct Screen {
    Eigen::Vector3d right, up;
    Eigen::Matrix3d axes() const {
      return (Eigen::Matrix3d() << right, up, right.cross(up)).finished();
    }
  };

  /// "+Y", "-X"…; nothing for another word.
  static std::optional<Eigen::Vector3d> axis_named(std::string_view word) {
    const double sign = word.starts_with('-') ? -1.0 : 1.0;
    if (word.starts_with('+') || word.starts_with('-')) word.remove_prefix(1);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (upper(word) == std::string(1, "XYZ"[axis])) return sign * Eigen::Vector3d::Unit(axis);
    }
    return std::nullopt;
  }

  /// Where the file does not say what points right, and where that would be the axis that is up, x
  /// does.
  Screen screen_of(const MarkerSequence& take) const {
    const auto stated = axis_named(trim(take.origin.y_screen));
    if (from_ == Up::automatic && !stated) {
      throw UsageError({.what = "the file does not say which axis is up",
                        .remedy = "Add from = \"y-up\" or from = \"z-up\" to the step"});
    }
    const Eigen::Vector3d up = from_ == Up::y   ? Eigen::Vector3d::UnitY()
                               : from_ == Up::z ? Eigen::Vector3d::UnitZ()
                                                : *stated;
    Eigen::Vector3d right =
        axis_named(trim(take.origin.x_screen)).value_or(Eigen::Vector3d::UnitX());
    if (std::abs(right.dot(up)) > 0.5) right = Eigen::Vector3d::UnitX();
    if (std::abs(right.dot(up)) > 0.5) right = Eigen::Vector3d::UnitY();
    return {right, up};
  }

  Up preset_ = Up::z, from_ = Up::automatic;
};

}  // namespace

std::shared_ptr<EditOperation> make_description_operation(std::string_view name) {
  if (name == "merge-subjects") return std::make_shared<MergeSubjects>();
  if (name == "anonymise") return std::make_shared<Anonymise>();
  if (name == "add-event") return std::make_shared<AddEvent>();
  if (name == "units") return std::make_shared<Units>();
  if (name == "axes") return std::make_shared<Axes>();
  return nullptr;
}

}  // namespace kinemesh
