// merge-subjects, anonymise, add-event, units, axes: what the take says about itself.
#include <algorithm>
#include <cmath>

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
    if (names.empty()) {
      throw UsageError({.what = "no marker belongs to " + join(subjects_, ", ", " or ")});
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
             {.unit = "s", .min = -1e9, .max = 1e9, .help = "since recorded frame 1"});
    p.text("context", event_.context, {.metavar = "TEXT", .help = "Left, Right, General"});
    p.text("subject", event_.subject, {.metavar = "NAME", .help = "whose event it is"});
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    if (event_.label.empty()) throw UsageError({.what = "'label' names the event, and is missing"});
    Event event = event_;
    if (frame_ > 0) {
      frames_between(take, frame_, frame_);
      if (!(take.rate_hz > 0.0)) throw UsageError({.what = "the take has no frame rate"});
      event.time_s = static_cast<double>(frame_ - 1) / take.rate_hz;
    }
    take.events.push_back(event);
    std::ranges::stable_sort(take.events, {}, &Event::time_s);
    return "added event " + event.label + " at " + format_fixed(event.time_s, 3) + " s";
  }

 private:
  Event event_;
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
    const auto now = millimetres_in(unit_);
    if (!now) throw UsageError({.what = "'" + unit_ + "' is no unit of length: mm, cm or m"});
    const double before = millimetres_in(take.origin.unit).value_or(1.0);
    take.origin.scale *= before / *now;  // the same step in the other unit
    scale_rotations(take.rotations, before / *now);
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
             {{Up::automatic, "auto", "as the file says (POINT:Y_SCREEN)"},
              {Up::y, "y-up", "y is up"},
              {Up::z, "z-up", "z is up"}},
             "how they lie now");
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    const Up now = from_ == Up::automatic ? up_of(take) : from_;
    const bool to_y = preset_ == Up::y;
    take.origin.x_screen = "+X";
    take.origin.y_screen = to_y ? "+Y" : "+Z";
    if (now == preset_) return "the axes already were as asked for";
    const auto turn = [to_y](auto& x, auto& y, auto& z) {
      (void)x;
      const auto old_y = y;
      y = to_y ? z : -z;
      z = to_y ? -old_y : old_y;
    };
    const std::span<float> p = take.positions();
    for (std::size_t i = 0; i < take.sample_count(); ++i) {
      if (take.markers()[i % take.marker_count()].kind > MarkerKind::virtual_point) continue;
      turn(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
    }
    for (Eigen::Vector3f& q : take.unlabelled.positions) turn(q.x(), q.y(), q.z());
    Eigen::Matrix3d whole = Eigen::Matrix3d::Identity();
    for (Eigen::Index c = 0; c < 3; ++c) turn(whole(0, c), whole(1, c), whole(2, c));
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      move_rotations(take.rotations, f, whole, Eigen::Vector3d::Zero());
    }
    if (C3dParameter* corners = take.parameters.find("FORCE_PLATFORM", "CORNERS")) {
      std::vector<double>& n = corners->numbers;
      for (std::size_t i = 0; i + 2 < n.size(); i += 3) turn(n[i], n[i + 1], n[i + 2]);
    }
    return std::string("turned the axes so that ") + (to_y ? "y" : "z") + " is up";
  }

 private:
  static Up up_of(const MarkerSequence& take) {
    if (take.origin.y_screen == "+Y") return Up::y;
    if (take.origin.y_screen == "+Z") return Up::z;
    throw UsageError({.what = "the file does not say which axis is up",
                      .remedy = "Add from = \"y-up\" or from = \"z-up\" to the step"});
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
