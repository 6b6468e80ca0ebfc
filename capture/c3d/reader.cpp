#include "capture/c3d/reader.h"

#include <algorithm>
#include <cmath>

#include "capture/c3d/analog_table.h"
#include "capture/c3d/byte_source.h"
#include "capture/c3d/event_group.h"
#include "capture/c3d/ezc3d_process.h"
#include "capture/c3d/header_block.h"
#include "capture/c3d/layout_resolver.h"
#include "capture/c3d/number_format.h"
#include "capture/c3d/parameter_access.h"
#include "capture/c3d/parameter_section.h"
#include "capture/c3d/point_decode.h"
#include "capture/c3d/point_table.h"
#include "capture/c3d/rotations.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 20;  // read at a time
constexpr uint8_t c3d_key = 80;

[[noreturn]] void refuse(const ByteSource& source, std::string what, std::string place = {}) {
  throw InputError({.what = std::move(what),
                    .file = source.name(),
                    .place = std::move(place),
                    .remedy = "Export the take again from the software that recorded it"});
}

// ---- header and parameters ----------------------------------------------------------------------

std::size_t leading_zeros(std::span<const std::byte> start) {
  const auto nonzero = std::ranges::find_if(start, [](std::byte b) { return b != std::byte{0}; });
  const auto zeros = static_cast<std::size_t>(nonzero - start.begin());
  const bool shifted =
      zeros > 0 && zeros + 1 < start.size() && start[zeros + 1] == std::byte{c3d_key};
  // A header whose pointer is 0 begins with one zero byte and the key.
  const bool in_place = start.size() > 1 && start[1] == std::byte{c3d_key};
  return shifted && !in_place ? zeros : 0;
}

/// Without a parameter section nothing names the processor: the one whose header makes sense.
Processor guess_processor(std::span<const std::byte> block) {
  int best_score = -1;
  Processor best = Processor::intel;
  for (const Processor p : {Processor::intel, Processor::sgi, Processor::dec}) {
    std::vector<C3dFinding> ignored;
    const C3dHeader h = decode_header(block, p, ignored);
    const float rate = h.rate_hz;
    const float scale = std::abs(h.scale);
    const int score = (rate >= 0.1F && rate <= 1e5F ? 2 : 0) +
                      (scale > 1e-6F && scale < 1e6F ? 2 : 0) +
                      (h.last_frame >= h.first_frame ? 1 : 0) +
                      (h.data_block >= 2 && h.data_block < 4096 ? 1 : 0);
    if (score > best_score) {
      best_score = score;
      best = p;
    }
  }
  return best;
}

/// Everything before the data section.
struct Opening {
  std::size_t leading = 0;
  Processor processor = Processor::intel;
  std::optional<C3dSectionStart> section_start;
  C3dSection section;
};

Opening read_opening(const ByteSource& source, C3dReadResult& result) {
  const std::vector<std::byte> start = source.bytes_at(0, std::size_t{128} * 1024);
  if (start.empty()) refuse(source, "the file is empty");
  if (start.size() < c3d_block) {
    refuse(source, "the file has " + count_of(start.size(), "byte") +
                       ", less than the header of a C3D file");
  }
  Opening opening;
  opening.leading = leading_zeros(start);
  const std::span<const std::byte> block = std::span(start).subspan(opening.leading);
  const bool keyed = block.size() > 1 && block[1] == std::byte{c3d_key};
  opening.section_start =
      find_section(source, opening.leading, static_cast<std::size_t>(block[0]), result.findings);
  if (!opening.section_start && !keyed) {
    refuse(source, "this is no C3D file: it has neither the header's key nor a parameter section");
  }
  if (opening.leading != 0) {
    result.findings.push_back(c3d_finding(
        "C3D102", count_of(opening.leading, "zero byte") + " before the header", "byte 0"));
  }
  if (!keyed) {
    result.findings.push_back(
        c3d_finding("C3D101", "the key is " + std::to_string(static_cast<int>(block[1])),
                    "byte " + std::to_string(opening.leading + 1)));
  }
  opening.processor =
      opening.section_start ? opening.section_start->processor : guess_processor(block);
  result.header = decode_header(block.first(std::min(block.size(), c3d_block)), opening.processor,
                                result.findings);
  return opening;
}

void read_parameters(const ByteSource& source, Opening& opening, C3dReadResult& result) {
  if (opening.section_start) {
    const std::size_t begin = opening.section_start->begin;
    const std::size_t data = opening.leading +
                             std::max<std::size_t>(result.header.data_block, 1) * c3d_block -
                             c3d_block;
    opening.section = parse_section(source, *opening.section_start,
                                    data > begin ? data : source.size(), result.findings);
  }
  if (opening.section.parameters.groups.empty()) {
    opening.section.end = 0;
    result.findings.push_back(c3d_finding("C3D104", "the header alone describes the data",
                                          "byte " + std::to_string(opening.leading)));
  }
  result.take.parameters = std::move(opening.section.parameters);
}

std::string manufacturer_of(const C3dParameters& tree) {
  std::vector<std::string> words;
  for (const char* name : {"COMPANY", "SOFTWARE", "VERSION_LABEL", "VERSION"}) {
    const C3dParameter* p = tree.find("MANUFACTURER", name);
    if (p == nullptr) continue;
    const bool doubled = std::string_view(name) == "VERSION" &&
                         tree.find("MANUFACTURER", "VERSION_LABEL") != nullptr;
    if (doubled) continue;
    std::vector<std::string> parts = p->strings();
    for (const double n : p->numbers) parts.push_back(format_number(n));
    bool converted = false;
    const std::string word =
        utf8_from(join(parts, p->type == C3dType::text ? " " : "."), converted);
    if (!trim(word).empty()) words.emplace_back(trim(word));
  }
  return join(words, " ");
}

void note_stray_events(C3dReadResult& result) {
  const double first = static_cast<double>(result.layout.first_frame - 1) / result.layout.rate_hz;
  const double last = first + static_cast<double>(result.layout.frames) / result.layout.rate_hz;
  for (const Event& e : result.take.events) {
    if (result.layout.frames == 0 ||
        (e.time_s >= first - 1.0 / result.layout.rate_hz && e.time_s <= last))
      continue;
    result.findings.push_back(c3d_finding("C3D602",
                                          e.label + " at " + format_fixed(e.time_s, 3) +
                                              " s, recorded are " + format_fixed(first, 3) +
                                              " to " + format_fixed(last, 3) + " s",
                                          "parameter EVENT:TIMES"));
  }
}

void note_subjects(const C3dParameters& tree, std::vector<C3dFinding>& findings) {
  const auto used = first_count(tree, "SUBJECTS", "USED");
  const std::size_t names = all_strings(tree, "SUBJECTS", "NAMES").size();
  if (used && tree.find("SUBJECTS", "NAMES") != nullptr && *used > names) {
    findings.push_back(c3d_finding(
        "C3D603", std::to_string(names) + " names for " + std::to_string(*used) + " subjects",
        "parameter SUBJECTS:NAMES"));
  }
}

// ---- data ---------------------------------------------------------------------------------------

/// Whole frames from the file, in the machine's number format, block by block.
class FrameBlocks {
 public:
  FrameBlocks(const ByteSource& source, const C3dLayout& layout)
      : source_(source),
        layout_(layout),
        per_block_(
            std::max<std::size_t>(1, block_bytes / std::max<std::size_t>(1, layout.frame_bytes))) {
    per_block_ = std::max<std::size_t>(1, std::min<std::size_t>(per_block_, layout.frames));
    if (layout.frames == 0) return;
    memory_ = Buffer<float>((per_block_ * layout.frame_bytes + 3) / 4);
  }
  std::size_t per_block() const { return per_block_; }
  /// Frames [first, first + count); count at most per_block().
  const std::byte* read(std::size_t first, std::size_t count) {
    auto* bytes = reinterpret_cast<std::byte*>(memory_.data());
    const std::size_t want = count * layout_.frame_bytes;
    if (source_.read_at(layout_.data_begin + first * layout_.frame_bytes, bytes, want) != want) {
      refuse(source_, "the file shrank while it was read",
             "frame " + std::to_string(layout_.first_frame + static_cast<int64_t>(first)));
    }
    if (layout_.storage == Storage::real) {
      reals_to_native(bytes, want / 4, layout_.processor);
    } else {
      swap_words(bytes, want / 2, layout_.processor);
    }
    return bytes;
  }

 private:
  const ByteSource& source_;
  const C3dLayout& layout_;
  std::size_t per_block_;
  Buffer<float> memory_;
};

/// Analog samples of the first frames as signed numbers, to tell signed from unsigned offsets.
std::vector<float> first_analog_samples(FrameBlocks& blocks, const C3dLayout& layout) {
  const std::size_t frames = std::min<std::size_t>({layout.frames, blocks.per_block(), 16});
  std::vector<float> samples;
  if (frames == 0 || layout.analog_channels == 0) return samples;
  const std::size_t width = layout.storage == Storage::real ? 4 : 2;
  const std::byte* bytes = blocks.read(0, frames);
  for (std::size_t f = 0; f < frames; ++f) {
    const std::byte* analog = bytes + f * layout.frame_bytes + 4 * layout.points * width;
    for (std::size_t i = 0; i < layout.analog_channels * layout.analog_samples; ++i) {
      samples.push_back(width == 4
                            ? read_real(analog + 4 * i, Processor::intel)
                            : static_cast<float>(read_i16(analog + 2 * i, Processor::intel)));
    }
  }
  return samples;
}

void note_occurrences(const PointOccurrences& all, const C3dLayout& layout,
                      std::vector<C3dFinding>& findings) {
  const auto note = [&](const char* code, const Occurrence& o, const std::string& what) {
    if (o.count == 0) return;
    findings.push_back(c3d_finding(
        code, count_of(o.count, "sample") + " " + what,
        "frame " + std::to_string(layout.first_frame + static_cast<int64_t>(o.first_frame))));
  };
  note("C3D407", all.zero_gaps, "at (0, 0, 0) with a residual of 0 or more, taken as gaps");
  note("C3D408", all.not_finite, "with coordinates that are no finite numbers, taken as gaps");
  note("C3D409", all.unsigned_minus_one, "marked as gaps by 65535");
  note("C3D410", all.odd_words, "whose residual word fits no 16 bits, taken as gaps");
  note("C3D412", all.sentinels, "at (-16512, -16512, -16512), taken as gaps");
  note("C3D413", all.far_away, "over 1 km from the origin");
}

void note_odd_analog(const AnalogData& analog, const C3dLayout& layout,
                     std::vector<C3dFinding>& findings) {
  if (layout.storage == Storage::integer) return;
  const std::size_t channels = analog.channels.size();
  std::vector<std::size_t> odd(channels, 0);
  bool any = false;
  for (std::size_t i = 0; i < analog.values.size(); i += channels) {
    // A sum is finite only if all its terms are (sums of samples do not overflow otherwise).
    float sum = 0.0F;
    for (std::size_t c = 0; c < channels; ++c) sum += analog.values[i + c] * 0.0F;
    if (sum == 0.0F) continue;
    any = true;
    for (std::size_t c = 0; c < channels; ++c) {
      odd[c] += std::isfinite(analog.values[i + c]) ? 0 : 1;
    }
  }
  for (std::size_t c = 0; any && c < channels; ++c) {
    if (odd[c] > 0) {
      findings.push_back(c3d_finding(
          "C3D508",
          count_of(odd[c], "sample") + " of " + analog.channels[c].label + " no finite numbers",
          "analog channel " + analog.channels[c].label));
    }
  }
}

void decode_data(FrameBlocks& blocks, const AnalogTable& analog, const PointTable& table,
                 const C3dReadOptions& options, const RunContext& ctx, C3dReadResult& result) {
  const C3dLayout& layout = result.layout;
  MarkerSequence& take = result.take;
  const std::size_t points = take.marker_count();
  const std::size_t analog_values = layout.analog_channels * layout.analog_samples;
  const std::size_t point_bytes = points * 4 * (layout.storage == Storage::real ? 4 : 2);
  take.analog.values = Buffer<float>(layout.frames * analog_values);
  PointDecoder point_decoder(layout, table, options.zero_points);
  const AnalogDecoder analog_decoder(layout, analog);
  for (std::size_t first = 0; first < layout.frames; first += blocks.per_block()) {
    ctx.check_cancelled();
    ctx.progress(static_cast<double>(first) / static_cast<double>(layout.frames));
    const std::size_t count = std::min<std::size_t>(blocks.per_block(), layout.frames - first);
    const std::byte* bytes = blocks.read(first, count);
    for (std::size_t f = first; f < first + count; ++f, bytes += layout.frame_bytes) {
      const std::size_t row = f * points;
      const FrameTarget to{take.positions().data() + 3 * row, take.flags().data() + row,
                           take.residuals().data() + row, take.camera_masks().data() + row};
      point_decoder.decode(bytes, to, f);
      analog_decoder.decode(bytes + point_bytes, take.analog.values.data() + f * analog_values);
    }
  }
  note_occurrences(point_decoder.occurrences(), layout, result.findings);
  if (analog_values > 0) note_odd_analog(take.analog, layout, result.findings);
}

// ---- all ----------------------------------------------------------------------------------------

void fill_origin(const PointTable& table, const ByteSource& source, C3dReadResult& result) {
  Origin& origin = result.take.origin;
  const C3dParameters& tree = result.take.parameters;
  origin.path = source.name();
  origin.unit = table.length_unit;
  origin.x_screen = std::string(trim(first_string(tree, "POINT", "X_SCREEN")));
  origin.y_screen = std::string(trim(first_string(tree, "POINT", "Y_SCREEN")));
  origin.manufacturer = manufacturer_of(tree);
  origin.processor = result.layout.processor;
  origin.storage = result.layout.storage;
  origin.scale = result.layout.scale;
}

C3dReadResult read_source(const ByteSource& source, const C3dReadOptions& options, bool with_data,
                          const RunContext& ctx) {
  options.validate();
  C3dReadResult result;
  Opening opening = read_opening(source, result);
  read_parameters(source, opening, result);
  C3dLayout& layout = result.layout;
  layout =
      resolve_layout({.source = source,
                      .header = result.header,
                      .parameters = result.take.parameters,
                      .leading = opening.leading,
                      .section_begin = opening.section_start ? opening.section_start->begin : 0,
                      .section_end = opening.section.end,
                      .processor = opening.processor,
                      .unstated_rate_hz = options.unstated.rate_hz},
                     result.findings);
  layout.places = std::move(opening.section.places);
  if (opening.section.end > layout.data_begin && layout.parameters_begin < layout.data_begin) {
    result.findings.push_back(
        c3d_finding("C3D210",
                    "the parameters end at byte " + std::to_string(opening.section.end) +
                        ", the data begin at " + std::to_string(layout.data_begin),
                    "byte " + std::to_string(layout.data_begin)));
  }
  if (opening.section.end == 0 && layout.frames == 0) {
    refuse(source, "the file has neither parameters nor a complete frame of data");
  }

  const C3dParameters& tree = result.take.parameters;
  PointTable table =
      decode_points_table(tree, layout.points, options.unstated.unit, result.findings);
  FrameBlocks blocks(source, layout);
  const AnalogTable analog =
      decode_analog_table(tree, layout, first_analog_samples(blocks, layout), result.findings);
  layout.analog_unsigned = analog.unsigned_samples;
  MarkerSequence take(with_data ? layout.frames : 0, std::move(table.markers), layout.rate_hz);
  table.markers = take.markers();
  take.parameters = std::move(result.take.parameters);
  result.take = std::move(take);
  result.take.first_frame = layout.first_frame;
  fill_origin(table, source, result);
  result.take.analog.channels = analog.channels;
  result.take.analog.rate_hz = analog_rate(result.take.parameters, layout, result.findings);
  result.take.analog.samples_per_frame = layout.analog_samples;
  result.take.events =
      decode_event_list(result.take.parameters, result.header.events, result.findings);
  note_stray_events(result);
  note_subjects(result.take.parameters, result.findings);
  if (with_data) {
    decode_data(blocks, analog, table, options, ctx, result);
    read_rotations(source, layout, result.take);
  }
  ctx.progress(1.0);
  return result;
}

}  // namespace

void C3dReadOptions::declare(ParameterSet& p) {
  unstated.declare(p);
  p.choice("reader", reader,
           {{C3dReader::own, "own", "Kinemesh's own reader"},
            {C3dReader::ezc3d, "ezc3d", "the ezc3d library, as a second opinion"}},
           "Which reader decodes C3D files");
  p.choice("zero-points", zero_points,
           {{ZeroPolicy::gap, "gap", "some software writes it where a marker was not seen"},
            {ZeroPolicy::valid, "valid", "a measured position, as the format says"}},
           "What a marker at exactly (0, 0, 0) with a residual of 0 or more is");
}

void C3dReadOptions::validate() const { validate_options(*this); }

C3dReadResult read_c3d(const std::filesystem::path& path, const C3dReadOptions& options,
                       const RunContext& ctx) {
  const FileSource source(path);
  C3dReadResult result = read_source(source, options, true, ctx);
  if (options.reader == C3dReader::ezc3d) reread_with_ezc3d(path, options, result, ctx);
  return result;
}

C3dReadResult read_c3d(std::span<const std::byte> bytes, const std::string& name,
                       const C3dReadOptions& options, const RunContext& ctx) {
  if (options.reader == C3dReader::ezc3d) {
    throw UsageError({.what = "ezc3d reads files, not memory"});
  }
  return read_source(MemorySource(bytes, name), options, true, ctx);
}

C3dHeadResult read_c3d_head(const std::filesystem::path& path, const C3dReadOptions& options) {
  return read_source(FileSource(path), options, false, {});
}

C3dHeadResult read_c3d_head(std::span<const std::byte> bytes, const std::string& name,
                            const C3dReadOptions& options) {
  return read_source(MemorySource(bytes, name), options, false, {});
}

}  // namespace kinemesh
