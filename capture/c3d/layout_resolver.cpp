#include "capture/c3d/layout_resolver.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "capture/c3d/header_block.h"
#include "capture/c3d/number_format.h"
#include "capture/c3d/parameter_access.h"
#include "capture/c3d/rotations.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// The values that the file gives for one quantity, the most trusted first.
template <class T>
struct Candidates {
  struct Entry {
    T value;
    std::string source;
  };
  std::vector<Entry> all;
  void add(const std::optional<T>& value, std::string source) {
    if (!value) return;
    const bool known = std::ranges::any_of(all, [&](const Entry& e) { return e.value == *value; });
    if (!known) all.push_back({*value, std::move(source)});
  }
  bool agree() const { return all.size() <= 1; }
};

struct AnalogShape {
  uint64_t channels = 0;
  uint64_t samples = 0;
  bool operator==(const AnalogShape& o) const {
    return values() == o.values() && channels == o.channels;
  }
  uint64_t values() const { return channels * samples; }
};

/// All that may be in doubt.
struct Question {
  Candidates<uint64_t> data_begin;
  Candidates<uint64_t> points;
  Candidates<AnalogShape> analog;
  Candidates<double> scale;  // candidates differ in sign only
  Candidates<uint64_t> frames;
};

struct Answer {
  std::size_t data_begin = 0, points = 0, analog = 0, scale = 0, frames = 0;  // indices
  auto indices() const { return std::tuple(data_begin, points, analog, scale, frames); }
};

std::string parameter_place(const char* name) { return std::string("parameter ") + name; }

uint64_t frame_bytes_of(uint64_t points, const AnalogShape& analog, double scale) {
  return (4 * points + analog.values()) * (scale < 0.0 ? 4 : 2);
}

/// How well a combination fits the file: 0 within the padding of the last block, 1 with bytes left
/// over, 2 with data missing.
int misfit(const Question& q, const Answer& a, uint64_t file_bytes) {
  const uint64_t begin = q.data_begin.all[a.data_begin].value;
  const uint64_t frame = frame_bytes_of(q.points.all[a.points].value, q.analog.all[a.analog].value,
                                        q.scale.all[a.scale].value);
  const uint64_t need = frame * q.frames.all[a.frames].value;
  if (begin > file_bytes || need > file_bytes - begin) return 2;
  return file_bytes - begin - need < c3d_block ? 0 : 1;
}

// ---- collecting ---------------------------------------------------------------------------------

std::optional<double> usable_rate(std::optional<double> rate) {
  return rate && *rate > 0.0 && *rate < 1e9 ? rate : std::nullopt;
}

void find_rate(const C3dHead& head, C3dLayout& layout, std::vector<C3dFinding>& findings) {
  const auto named = usable_rate(first_number(head.parameters, "POINT", "RATE"));
  const auto header =
      usable_rate(std::isfinite(head.header.rate_hz) ? std::optional<double>(head.header.rate_hz)
                                                     : std::nullopt);
  // Files of analog data alone may give no other rate.
  const auto analog = usable_rate(first_number(head.parameters, "ANALOG", "RATE"));
  const uint16_t samples = head.header.analog_samples;
  const auto derived = analog && samples > 0 ? std::optional<double>(*analog / samples) : analog;
  const auto told = usable_rate(head.unstated_rate_hz);
  layout.rate_hz = named.value_or(header.value_or(derived.value_or(told.value_or(1.0))));
  if (!named && !header && derived) {
    findings.push_back(c3d_finding("C3D306",
                                   "neither header nor POINT:RATE gives a frame rate; ANALOG:RATE "
                                   "makes it " +
                                       format_number(*derived) + " Hz",
                                   parameter_place("POINT:RATE")));
  } else if (!named && !header && !told) {
    findings.push_back(c3d_finding("C3D316", "neither header nor POINT:RATE gives a frame rate",
                                   parameter_place("POINT:RATE")));
  } else if (!named && header && head.section_end != 0) {
    findings.push_back(c3d_finding(
        "C3D306", "there is no POINT:RATE; the header says " + format_number(*header) + " Hz",
        parameter_place("POINT:RATE")));
  } else if (named && header && std::abs(*named - *header) > 1e-3 * *named) {
    findings.push_back(c3d_finding("C3D307",
                                   "POINT:RATE is " + format_number(*named) +
                                       " Hz, the header says " + format_number(*header) + " Hz",
                                   parameter_place("POINT:RATE")));
  }
}

std::optional<double> usable_scale(std::optional<double> scale) {
  return scale && std::isfinite(*scale) && *scale != 0.0 ? scale : std::nullopt;
}

/// The shortest decimal text of a stored 32-bit real.
std::string real_text(double value) {
  std::string text;
  append_number(text, static_cast<float>(value));
  return text;
}

Candidates<double> scales(const C3dHead& head, std::vector<C3dFinding>& findings) {
  Candidates<double> c;
  const auto named = usable_scale(first_number(head.parameters, "POINT", "SCALE"));
  const auto header = usable_scale(head.header.scale);
  if (named && header && (*named < 0.0) != (*header < 0.0)) {
    c.add(named, "POINT:SCALE");
    c.add(header, "the header");
  } else if (named || header) {
    c.add(named ? named : header, "");
    if (named && header && std::abs(*named - *header) > 1e-5 * std::abs(*named)) {
      findings.push_back(c3d_finding(
          "C3D309",
          "POINT:SCALE is " + real_text(*named) + ", the header says " + real_text(*header),
          parameter_place("POINT:SCALE")));
    }
  } else {
    findings.push_back(c3d_finding("C3D310", "neither header nor POINT:SCALE gives a scale",
                                   parameter_place("POINT:SCALE")));
    c.add(-1.0, "floats");
    c.add(1.0, "integers");
  }
  return c;
}

Candidates<uint64_t> data_begins(const C3dHead& head, std::vector<C3dFinding>& findings) {
  Candidates<uint64_t> c;
  const auto add = [&](uint64_t block, const std::string& source) {
    if (block == 0) return;
    const uint64_t begin = head.leading + (block - 1) * c3d_block;
    const uint64_t unshifted = (block - 1) * c3d_block;
    if (begin >= c3d_block) c.add(begin, source);
    if (head.leading != 0 && unshifted >= c3d_block) c.add(unshifted, source);
  };
  add(head.header.data_block, "the header");
  add(first_count(head.parameters, "POINT", "DATA_START").value_or(0), "POINT:DATA_START");
  if (head.header.data_block == 0 && !c.all.empty()) {
    findings.push_back(c3d_finding("C3D303",
                                   "the header does not say where the data begin; POINT:DATA_START "
                                   "says byte " +
                                       std::to_string(c.all.front().value),
                                   "byte " + std::to_string(head.leading + 16)));
  }
  const uint64_t size = head.source.size();
  const auto outside = [&](const auto& e) { return e.value > size; };
  for (const auto& e : c.all) {
    if (!outside(e) || std::ranges::all_of(c.all, outside)) continue;
    findings.push_back(c3d_finding("C3D303",
                                   e.source + " says byte " + std::to_string(e.value) +
                                       ", which lies outside the file and is not used",
                                   parameter_place("POINT:DATA_START")));
  }
  std::erase_if(c.all, outside);
  if (c.all.empty()) {
    const uint64_t end = std::max<uint64_t>(head.section_end, head.leading + c3d_block);
    c.add(head.leading + (end - head.leading + c3d_block - 1) / c3d_block * c3d_block,
          "the end of the parameters");
  }
  return c;
}

Candidates<uint64_t> point_counts(const C3dHead& head) {
  Candidates<uint64_t> c;
  const auto used = first_count(head.parameters, "POINT", "USED");
  c.add(used && *used <= 65'535 ? used : std::nullopt, "POINT:USED");
  c.add(head.header.points, "the header");
  return c;
}

Candidates<AnalogShape> analog_shapes(const C3dHead& head, double rate) {
  Candidates<AnalogShape> c;
  const uint64_t total = head.header.analog_per_frame;
  const uint64_t samples = head.header.analog_samples;
  const auto stored = first_count(head.parameters, "ANALOG", "USED");
  const bool named = stored && *stored <= 65'535;
  const uint64_t used = named ? *stored : 0;
  const auto analog_rate = usable_rate(first_number(head.parameters, "ANALOG", "RATE"));
  const auto ratio =
      analog_rate ? static_cast<uint64_t>(std::min(std::round(*analog_rate / rate), 65535.0)) : 0;
  const auto shape = [](uint64_t channels, uint64_t per_frame) {
    return std::optional<AnalogShape>(channels * per_frame == 0 ? AnalogShape{}
                                                                : AnalogShape{channels, per_frame});
  };
  const auto header = [&]() -> std::optional<AnalogShape> {
    if (total == 0) return AnalogShape{};
    if (samples != 0 && total % samples == 0) return shape(total / samples, samples);
    if (used != 0 && total % used == 0) return shape(used, total / used);
    return shape(total, 1);
  }();
  if (used != 0 && used * samples == total) {
    c.add(header, "the header");
    // Channels that the header knows nothing of are there only if nothing else fits.
    if (total == 0 && ratio != 0) c.add(shape(used, ratio), "ANALOG:USED and ANALOG:RATE");
    return c;
  }
  if (named && samples != 0) {
    c.add(shape(used, samples), "ANALOG:USED and the header's samples per frame");
  }
  if (named && ratio != 0) c.add(shape(used, ratio), "ANALOG:USED and ANALOG:RATE");
  if (named && used == 0) c.add(AnalogShape{}, "ANALOG:USED");
  c.add(header, "the header");
  return c;
}

Candidates<uint64_t> frame_counts(const C3dHead& head) {
  Candidates<uint64_t> c;
  const auto positive = [](std::optional<uint64_t> n) { return n && *n > 0 ? n : std::nullopt; };
  c.add(positive(first_count(head.parameters, "POINT", "LONG_FRAMES")), "POINT:LONG_FRAMES");
  const auto start = long_count(head.parameters, "TRIAL", "ACTUAL_START_FIELD");
  const auto end = long_count(head.parameters, "TRIAL", "ACTUAL_END_FIELD");
  if (start && end && *end >= *start && *end > 0) {
    c.add(*end - *start + 1, "TRIAL:ACTUAL_START_FIELD and ACTUAL_END_FIELD");
  }
  const C3dHeader& h = head.header;
  const auto named = positive(first_count(head.parameters, "POINT", "FRAMES"));
  // A header that saturates at 65535 knows less than a real-valued POINT:FRAMES.
  if (named && *named > 65535) c.add(named, "POINT:FRAMES");
  if (h.last_frame >= h.first_frame && h.last_frame > 0) {
    // With a first frame of 0, some count from 0 and others mean 1.
    const bool from_one = h.first_frame == 0 && named && *named == h.last_frame;
    c.add(h.last_frame - h.first_frame + (from_one ? 0 : 1), "the header");
    if (h.first_frame == 0 && !named) c.add(h.last_frame, "the header");
  }
  c.add(named, "POINT:FRAMES");
  return c;
}

// ---- deciding -----------------------------------------------------------------------------------

Answer best_fit(const Question& q, uint64_t file_bytes) {
  Answer best;
  auto best_rank = std::tuple(3, std::size_t{0}, best.indices());
  Answer a;
  for (a.data_begin = 0; a.data_begin < q.data_begin.all.size(); ++a.data_begin) {
    for (a.points = 0; a.points < q.points.all.size(); ++a.points) {
      for (a.analog = 0; a.analog < q.analog.all.size(); ++a.analog) {
        for (a.scale = 0; a.scale < q.scale.all.size(); ++a.scale) {
          for (a.frames = 0; a.frames < q.frames.all.size(); ++a.frames) {
            const std::size_t distrust = a.data_begin + a.points + a.analog + a.scale + a.frames;
            const auto rank = std::tuple(misfit(q, a, file_bytes), distrust, a.indices());
            if (rank < best_rank) {
              best_rank = rank;
              best = a;
            }
          }
        }
      }
    }
  }
  return best;
}

/// The points end with the file, or where rotations begin.
uint64_t points_end(const C3dLayout& layout) {
  const bool behind = layout.rotations > 0 && layout.rotations_begin < layout.file_bytes &&
                      layout.rotations_begin > layout.parameters_end;
  return behind ? layout.rotations_begin : layout.file_bytes;
}

/// Complete frames up to `size`, without those that are zero padding of its last
/// block.
uint64_t frames_to_the_end(const ByteSource& source, uint64_t begin, uint64_t size,
                           uint64_t frame_bytes) {
  if (frame_bytes == 0 || begin >= size) return 0;
  const uint64_t tail = std::min<uint64_t>(c3d_block - 1, size - begin);
  const std::vector<std::byte> last = source.bytes_at(size - tail, tail);
  uint64_t zeros = 0;
  while (zeros < last.size() && last[last.size() - 1 - zeros] == std::byte{0}) ++zeros;
  const uint64_t used = size - begin - zeros;
  return std::min((used + frame_bytes - 1) / frame_bytes, (size - begin) / frame_bytes);
}

/// Counts that were cut to 16 bits, by saturation or by wrapping, are replaced by what the file
/// holds.
void mend_saturated_count(const C3dHead& head, uint64_t end, Question& q, Answer& a,
                          std::vector<C3dFinding>& findings) {
  const uint64_t declared = q.frames.all[a.frames].value;
  if (misfit(q, a, end) != 1 || declared > 65'536) return;
  const uint64_t begin = q.data_begin.all[a.data_begin].value;
  const uint64_t frame = frame_bytes_of(q.points.all[a.points].value, q.analog.all[a.analog].value,
                                        q.scale.all[a.scale].value);
  const uint64_t held = frames_to_the_end(head.source, begin, end, frame);
  const bool saturated = declared >= 65'535 || head.header.last_frame == 65'535;
  const bool wrapped = held > declared && (held - declared) % 65'536 == 0;
  if (declared != 0 && ((!saturated && !wrapped) || held <= declared)) return;
  findings.push_back(c3d_finding("C3D312",
                                 "the counts say " + std::to_string(declared) +
                                     " frames, the data section holds " + std::to_string(held),
                                 "byte 6"));
  q.frames.all.push_back({held, "the file's size"});
  a.frames = q.frames.all.size() - 1;
}

std::string said(const auto& candidates, const auto& text) {
  std::string all;
  for (const auto& e : candidates.all) {
    all += (all.empty() ? "" : ", ") + e.source + " says " + text(e.value);
  }
  return all;
}

void report(const Question& q, const Answer& a, bool has_parameters, uint16_t last_frame,
            std::vector<C3dFinding>& findings) {
  const auto number = [](uint64_t v) { return std::to_string(v); };
  const auto taken = [](const std::string& source) {
    return "; " + source + " fits the data and is used";
  };
  if (!q.data_begin.agree()) {
    findings.push_back(
        c3d_finding("C3D303",
                    said(q.data_begin, [](uint64_t v) { return "byte " + std::to_string(v); }) +
                        taken(q.data_begin.all[a.data_begin].source),
                    parameter_place("POINT:DATA_START")));
  }
  if (!q.points.agree()) {
    findings.push_back(c3d_finding("C3D304",
                                   said(q.points, number) + taken(q.points.all[a.points].source),
                                   parameter_place("POINT:USED")));
  }
  if (!q.analog.agree()) {
    const auto text = [](const AnalogShape& s) {
      return std::to_string(s.channels) + " channels of " + std::to_string(s.samples) + " samples";
    };
    findings.push_back(c3d_finding("C3D305",
                                   said(q.analog, text) + taken(q.analog.all[a.analog].source),
                                   parameter_place("ANALOG:USED")));
  }
  if (!q.scale.agree() && !q.scale.all[0].source.empty() && q.scale.all[0].source != "floats") {
    const auto text = [](double s) { return std::string(s < 0 ? "floats" : "integers"); };
    findings.push_back(c3d_finding("C3D308",
                                   said(q.scale, text) + taken(q.scale.all[a.scale].source),
                                   parameter_place("POINT:SCALE")));
  }
  if (!q.frames.agree() && q.frames.all[a.frames].source != "the file's size") {
    // That 16-bit counts fall short of a long take, or of a late one, is how the format works.
    const uint64_t frames = q.frames.all[a.frames].value;
    const bool natural = std::ranges::all_of(q.frames.all, [&](const auto& e) {
      const bool saturated =
          e.value >= 65'534 || (e.source == "the header" && last_frame == 65'535);
      return e.value == frames || saturated || (frames > 65'535 && e.value == frames % 65'536);
    });
    if (natural) {
      findings.push_back(c3d_finding(
          "C3D313", std::to_string(frames) + " frames, by " + q.frames.all[a.frames].source,
          parameter_place("POINT:FRAMES")));
    } else if (has_parameters) {
      findings.push_back(c3d_finding("C3D301",
                                     said(q.frames, number) + taken(q.frames.all[a.frames].source),
                                     parameter_place("POINT:FRAMES")));
    }
  }
}

int64_t first_frame_of(const C3dHead& head, uint64_t frames, std::vector<C3dFinding>& findings) {
  const auto start = long_count(head.parameters, "TRIAL", "ACTUAL_START_FIELD");
  const auto end = long_count(head.parameters, "TRIAL", "ACTUAL_END_FIELD");
  if (start && end && *start > 0 && *end >= *start && *end - *start + 1 == frames) {
    return static_cast<int64_t>(*start);
  }
  if (start && *start > 65'534 && head.header.first_frame == 65'535) {
    return static_cast<int64_t>(*start);
  }
  if (head.header.first_frame == 0) {
    findings.push_back(c3d_finding("C3D105", "the first frame is 0", "byte 6"));
    return 1;
  }
  return head.header.first_frame;
}

void count_frames(const C3dHead& head, C3dLayout& layout, std::vector<C3dFinding>& findings) {
  const uint64_t size = head.source.size();
  const bool only_rotations = layout.frame_bytes == 0;
  const uint64_t begin = only_rotations ? layout.rotations_begin : layout.data_begin;
  const uint64_t frame = only_rotations
                             ? layout.rotations * layout.rotation_samples * rotation_bytes
                             : layout.frame_bytes;
  // A count that saturated at 16 bits does not reach into the rotations.
  const bool saturated = !only_rotations && layout.declared_frames >= 65'535;
  const uint64_t end = saturated ? points_end(layout) : size;
  const uint64_t held = frame == 0 || begin >= end ? 0 : (end - begin) / frame;
  layout.frames = std::min(layout.declared_frames, held);
  if (layout.frames < layout.declared_frames && (frame != 0 || layout.declared_frames > 0)) {
    findings.push_back(c3d_finding(
        "C3D302",
        std::to_string(layout.declared_frames) + " frames are declared, " +
            std::to_string(layout.frames) + " are complete",
        "frame " + std::to_string(layout.first_frame + static_cast<int64_t>(layout.frames))));
  }
  layout.data_end = only_rotations ? layout.data_begin : begin + layout.frames * frame;
  if (layout.rotations == 0 && layout.frames == layout.declared_frames && size > layout.data_end &&
      size - layout.data_end >= c3d_block) {
    findings.push_back(c3d_finding(
        "C3D311", std::to_string(size - layout.data_end) + " bytes follow the last frame",
        "byte " + std::to_string(layout.data_end)));
  }
}

void note_missing_counts(const C3dHead& head, std::vector<C3dFinding>& findings) {
  if (head.section_end == 0) return;
  std::vector<std::string> missing;
  if (head.header.points != 0 && !first_count(head.parameters, "POINT", "USED"))
    missing.emplace_back("POINT:USED");
  if (head.header.analog_per_frame != 0 && !first_count(head.parameters, "ANALOG", "USED")) {
    missing.emplace_back("ANALOG:USED");
  }
  if (!head.parameters.find("POINT", "FRAMES")) {
    findings.push_back(
        c3d_finding("C3D320", "there is no POINT:FRAMES", parameter_place("POINT:FRAMES")));
  }
  for (const std::string& name : missing) {
    findings.push_back(c3d_finding("C3D318", "there is no " + name, "parameter " + name));
  }
}

}  // namespace

C3dLayout resolve_layout(const C3dHead& head, std::vector<C3dFinding>& findings) {
  C3dLayout layout;
  layout.file_bytes = head.source.size();
  layout.leading_bytes = head.leading;
  layout.parameters_begin = head.section_begin;
  layout.parameters_end = head.section_end;
  layout.processor = head.processor;
  find_rate(head, layout, findings);
  find_rotations(head, layout);
  note_missing_counts(head, findings);
  Question q{.data_begin = data_begins(head, findings),
             .points = point_counts(head),
             .analog = analog_shapes(head, layout.rate_hz),
             .scale = scales(head, findings),
             .frames = frame_counts(head)};
  q.frames.add(q.frames.all.empty() ? std::optional<uint64_t>(0) : std::nullopt, "nothing");
  const uint64_t end = points_end(layout);
  Answer a = best_fit(q, end);
  mend_saturated_count(head, end, q, a, findings);
  report(q, a, head.section_end != 0, head.header.last_frame, findings);

  layout.data_begin = q.data_begin.all[a.data_begin].value;
  layout.points = q.points.all[a.points].value;
  const AnalogShape analog = q.analog.all[a.analog].value;
  layout.analog_channels = analog.values() == 0 ? 0 : analog.channels;
  layout.analog_samples = analog.values() == 0 ? 0 : analog.samples;
  layout.scale = q.scale.all[a.scale].value;
  layout.storage = layout.scale < 0.0 ? Storage::real : Storage::integer;
  layout.frame_bytes = frame_bytes_of(layout.points, analog, layout.scale);
  layout.declared_frames = q.frames.all[a.frames].value;
  layout.first_frame = first_frame_of(head, layout.declared_frames, findings);
  if (layout.data_begin >= layout.file_bytes && layout.frame_bytes != 0 &&
      layout.declared_frames != 0) {
    findings.push_back(c3d_finding("C3D317",
                                   "the data would begin at byte " +
                                       std::to_string(layout.data_begin) + " of " +
                                       std::to_string(layout.file_bytes),
                                   "byte 16"));
  }
  count_frames(head, layout, findings);
  settle_rotations(layout, findings);
  if (layout.points == 0) {
    findings.push_back(
        c3d_finding("C3D314", "the file has no points", parameter_place("POINT:USED")));
  }
  return layout;
}

}  // namespace kinemesh
