// crop, join, resample.
#include <cmath>

#include "capture/edit/operation.h"
#include "capture/edit/timeline.h"
#include "capture/session.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

class Crop : public EditOperation {
 public:
  std::string_view name() const override { return "crop"; }
  void declare(ParameterSet& p) override { declare_frames(p, from_, to_); }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    const FrameSpan span = frames_between(take, from_, to_);
    const int64_t first = take.first_frame + static_cast<int64_t>(span.begin);
    const std::size_t events = take.events.size();
    take = crop_frames(take, {span.begin, span.end});
    std::string text = "kept the " + count_of(take.frame_count(), "frame") + " from " +
                       std::to_string(first) + " on, numbered from 1";
    if (events > take.events.size()) {
      text += "; " + count_of(events - take.events.size(), "event") + " outside dropped";
    }
    return text;
  }

 private:
  int64_t from_ = 0, to_ = 0;
};

class Join : public EditOperation {
 public:
  std::string_view name() const override { return "join"; }
  std::vector<std::string> files() const override { return {file_}; }
  void declare(ParameterSet& p) override {
    p.text("file", file_, {.metavar = "FILE", .help = "the take that follows"});
    p.number("pause", pause_s_,
             {.unit = "s", .min = 0, .max = 86400, .help = "time without data between the two"});
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    if (file_.empty()) throw UsageError({.what = "'file' says which take follows, and is missing"});
    const MarkerSequence other = read_session(context.folder / file_, {}, context.run);
    const auto pause = static_cast<std::size_t>(std::lround(pause_s_ * take.rate_hz));
    std::vector<std::string> notes;
    take = join_takes(take, other, pause, &notes);
    std::string text = "joined " + count_of(other.frame_count(), "frame") + " of " + file_;
    for (const std::string& note : notes) text += "; " + note;
    return text;
  }

 private:
  std::string file_;
  double pause_s_ = 0.0;
};

class Resample : public EditOperation {
 public:
  std::string_view name() const override { return "resample"; }
  void declare(ParameterSet& p) override {
    p.number("rate", rate_hz_,
             {.unit = "Hz", .min = 0.0, .max = 1e6, .help = "frames per second afterwards"});
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    constexpr double least_hz = 0.001;
    if (rate_hz_ < least_hz) {
      throw UsageError({.what = "'rate' says how many frames a second there are afterwards, and is "
                                "missing or below 0.001 Hz",
                        .remedy = "Add a line such as rate = 60"});
    }
    const double before = take.rate_hz;
    const double analog = take.analog.rate_hz;
    const bool turning = !take.rotations.values.empty();
    take = resample_take(take, rate_hz_, context.run);
    std::string text = "resampled from " + format_number(before) + " to " +
                       format_number(rate_hz_) + " Hz, " + count_of(take.frame_count(), "frame") +
                       (turning ? "; the rotations are left out" : "");
    if (!take.analog.channels.empty() && std::abs(take.analog.rate_hz - analog) > 1e-6 * analog) {
      text += "; the analog data from " + format_number(analog) + " to " +
              format_number(take.analog.rate_hz) + " Hz, to be whole samples a frame";
    }
    return text;
  }

 private:
  double rate_hz_ = 0.0;
};

}  // namespace

std::shared_ptr<EditOperation> make_timeline_operation(std::string_view name) {
  if (name == "crop") return std::make_shared<Crop>();
  if (name == "join") return std::make_shared<Join>();
  if (name == "resample") return std::make_shared<Resample>();
  return nullptr;
}

}  // namespace kinemesh
