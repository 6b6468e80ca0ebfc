#include "capture/c3d/repair.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "capture/c3d/header_block.h"
#include "capture/c3d/number_format.h"
#include "capture/c3d/rotations.h"
#include "capture/c3d/write_plan.h"
#include "capture/c3d/writer.h"
#include "config/error.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// What the repair does about each deviation; codes that are missing here are left as they are.
const std::map<std::string_view, std::string_view>& deeds() {
  static const std::map<std::string_view, std::string_view> all = {
      {"C3D101", "the key was written"},
      {"C3D102", "the zero bytes were removed"},
      {"C3D103", "the header points to the parameter section now"},
      {"C3D104", "a parameter section was written from what the header says"},
      {"C3D105", "frames are counted from 1 now"},
      {"C3D107", "the event without a time was left out"},
      {"C3D201", "the block count was corrected"},
      {"C3D202", "the processor byte was corrected"},
      {"C3D203", "the parameter section was written anew with the parameters that could be read"},
      {"C3D204", "the parameter was written with the values that its record holds"},
      {"C3D205", "the parameter that could not be read was left out"},
      {"C3D206", "the group was declared"},
      {"C3D207", "the missing byte was put in"},
      {"C3D208", "the second of the two was left out or renamed"},
      {"C3D209", "the description was cut to what its record holds"},
      {"C3D210", "the parameter section was given the room it needs"},
      {"C3D211", "the bytes between the records were removed"},
      {"C3D212", "the parameter section was written anew with the parameters that could be read"},
      {"C3D213", "the pointer of the last record was corrected"},
      {"C3D214", "the entries beyond 255 were written to a second parameter"},
      {"C3D301", "header and parameters give the same number of frames now"},
      {"C3D302", "the complete frames were kept and the counts corrected"},
      {"C3D303", "header and POINT:DATA_START agree now"},
      {"C3D304", "header and POINT:USED agree now"},
      {"C3D305", "header and the ANALOG group agree now"},
      {"C3D306", "POINT:RATE was added"},
      {"C3D307", "header and POINT:RATE agree now"},
      {"C3D308", "header and POINT:SCALE agree now"},
      {"C3D309", "header and POINT:SCALE agree now"},
      {"C3D310", "the scale was written"},
      {"C3D312", "the number of frames was written to POINT:LONG_FRAMES and the TRIAL group"},
      {"C3D317", "the pointers to the data were corrected"},
      {"C3D318", "the missing counts were added"},
      {"C3D319", "missing rotations were marked as not measured, or the group as empty"},
      {"C3D320", "the missing count was added"},
      {"C3D401", "the missing labels were added"},
      {"C3D406", "the text was converted to UTF-8"},
      {"C3D408", "these samples were marked as gaps"},
      {"C3D410", "these samples were marked as gaps"},
      {"C3D501", "ANALOG:RATE was added"},
      {"C3D502", "ANALOG:RATE was corrected"},
      {"C3D504", "the missing labels were added"},
      {"C3D505", "the missing scales and offsets were added"},
      {"C3D507", "ANALOG:GEN_SCALE was written"},
      {"C3D601",
       "the EVENT parameters were written anew from the events that can be read; incomplete ones "
       "were left out"},
      {"C3D603", "the SUBJECTS group was made consistent"},
  };
  return all;
}

bool needs_repair(const std::vector<C3dFinding>& findings) {
  return std::ranges::any_of(findings,
                             [](const C3dFinding& f) { return deeds().contains(f.code); });
}

/// A fourth word that every reader takes for a gap, in place of what cannot be read.
std::string gap_word(const C3dLayout& layout) {
  std::string word;
  if (layout.storage == Storage::real) {
    append_real(word, -1.0F, layout.processor);
  } else {
    append_u16(word, 0xFFFF, layout.processor);
  }
  return word;
}

/// Whether a stored point (floats) can be read as the format says.
bool is_sound(const std::byte* point, Processor p) {
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(read_real(point + 4 * k, p))) return false;
  }
  const float word = read_real(point + 12, p);
  return word > -1.0F && word < 32768.0F;
}

/// Marks points of a real-valued data section whose numbers make no sense as gaps.
std::size_t mark_gaps(std::string& data, const C3dReadResult& read) {
  const C3dLayout& layout = read.layout;
  const bool wanted = has_code(read.findings, "C3D408") || has_code(read.findings, "C3D410");
  if (!wanted || layout.storage != Storage::real) return 0;
  const std::string gap = gap_word(layout);
  std::size_t marked = 0;
  for (std::size_t f = 0; f < layout.frames; ++f) {
    for (std::size_t m = 0; m < layout.points; ++m) {
      char* point = data.data() + f * layout.frame_bytes + 16 * m;
      const auto* bytes = reinterpret_cast<const std::byte*>(point);
      const float word = read_real(bytes + 12, layout.processor);
      const bool gap_already = (word <= -1.0F && word >= -32768.0F) || word == 65535.0F;
      if (gap_already || is_sound(bytes, layout.processor)) continue;
      std::memcpy(point + 12, gap.data(), gap.size());
      ++marked;
    }
  }
  return marked;
}

/// Everything behind the parameters: the frames, and what follows them unless the file is cut off.
std::string data_section(std::string_view bytes, const C3dReadResult& read) {
  const C3dLayout& layout = read.layout;
  const std::size_t begin = std::min<std::size_t>(layout.data_begin, bytes.size());
  const bool cut_off = layout.frames < layout.declared_frames && layout.frame_bytes > 0;
  const bool rotations = !read.take.rotations.values.empty();
  const std::size_t end =
      cut_off || rotations ? std::min<std::size_t>(layout.data_end, bytes.size()) : bytes.size();
  std::string data(bytes.substr(begin, std::max(begin, end) - begin));
  data.resize((data.size() + c3d_block - 1) / c3d_block * c3d_block, '\0');
  // Rotations follow in the next block, wherever they were; DATA_START says so.
  const auto append = [&](const void* from, std::size_t count) {
    data.append(static_cast<const char*>(from), count);
  };
  if (rotations) write_rotations(read.take.rotations, layout.processor, append);
  return data;
}

/// The plan for header and parameters.
C3dWritePlan plan_repair(const C3dReadResult& read) {
  C3dWriteOptions same;
  same.scale = std::abs(read.layout.scale);
  return plan_c3d(read.take, same);
}

bool same_bits(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Samples and analog values that differ between two reads of the same frames.
std::size_t count_changes(const MarkerSequence& a, const MarkerSequence& b) {
  if (a.frame_count() != b.frame_count() || a.marker_count() != b.marker_count()) {
    return std::max(a.sample_count(), b.sample_count());
  }
  std::size_t changed = 0;
  for (std::size_t i = 0; i < a.sample_count(); ++i) {
    const bool valid = (a.flags()[i] & SampleFlag::valid) != 0;
    bool same = a.flags()[i] == b.flags()[i];
    for (std::size_t k = 0; same && valid && k < 3; ++k) {
      same = same_bits(a.positions()[3 * i + k], b.positions()[3 * i + k]);
    }
    if (same && valid) {
      same = same_bits(a.residuals()[i], b.residuals()[i]) &&
             a.camera_masks()[i] == b.camera_masks()[i];
    }
    changed += same ? 0 : 1;
  }
  const Buffer<float>& x = a.analog.values;
  const Buffer<float>& y = b.analog.values;
  if (x.size() != y.size()) return changed + std::max(x.size(), y.size());
  for (std::size_t i = 0; i < x.size(); ++i) changed += same_bits(x[i], y[i]) ? 0 : 1;
  const Buffer<float>& r = a.rotations.values;
  const Buffer<float>& s = b.rotations.values;
  if (r.size() != s.size()) return changed + std::max(r.size(), s.size());
  for (std::size_t i = 0; i < r.size(); ++i) changed += same_bits(r[i], s[i]) ? 0 : 1;
  return changed;
}

std::span<const std::byte> as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

/// Header, parameters and the old data section; empty when their frames do not fit each other.
std::string with_old_data(std::string_view bytes, const C3dReadResult& read,
                          C3dRepairResult& result) {
  C3dWritePlan plan = plan_repair(read);
  plan.header.events = read.header.events;
  const std::size_t width = plan.storage == Storage::real ? 4 : 2;
  const std::size_t frame_bytes =
      (4 * plan.points + read.layout.analog_channels * read.layout.analog_samples) * width;
  const bool fits = plan.storage == read.layout.storage && frame_bytes == read.layout.frame_bytes &&
                    static_cast<float>(plan.scale) == static_cast<float>(read.layout.scale);
  if (!fits) return {};
  std::string data = data_section(bytes, read);
  result.gaps_marked = mark_gaps(data, read);
  return encode_header(plan.header, plan.processor) + plan.section + data;
}

std::string said(const C3dFinding& f) {
  return (f.place.empty() ? "" : f.place + ": ") + f.message;
}

void list_mends(C3dRepairResult& result) {
  for (const C3dFinding& f : result.before) {
    const auto deed = deeds().find(f.code);
    if (deed == deeds().end() || has_code(result.after.findings, f.code)) continue;
    result.mended.push_back({f, std::string(deed->second)});
  }
}

}  // namespace

std::string repaired_bytes(std::string_view bytes, const std::string& name,
                           const C3dReadOptions& options, C3dRepairResult& result) {
  C3dReadOptions own = options;
  own.reader = C3dReader::own;
  const C3dReadResult read = read_c3d(as_bytes(bytes), name, own);
  result.before = read.findings;
  result.frames = read.layout.frames;
  result.frames_lost = read.layout.declared_frames - read.layout.frames;
  result.samples = read.take.sample_count();
  if (!needs_repair(read.findings)) {
    result.copied = true;
    result.data_verbatim = true;
    return std::string(bytes);
  }
  std::string repaired = with_old_data(bytes, read, result);
  if (!repaired.empty()) {
    result.changed = count_changes(read.take, read_c3d(as_bytes(repaired), name, own).take);
    result.data_verbatim = result.changed == 0;
  }
  if (!result.data_verbatim) {
    // The data cannot stay as they are under the new parameters: written anew from their values.
    std::string anew = encode_c3d(read.take);
    const std::size_t changed = count_changes(read.take, read_c3d(as_bytes(anew), name, own).take);
    if (repaired.empty() || changed < result.changed) {
      repaired = std::move(anew);
      result.changed = changed;
      result.gaps_marked = 0;
    }
  }
  return repaired;
}

C3dRepairResult repair_c3d(const std::filesystem::path& path, const std::filesystem::path& output,
                           const C3dCheckOptions& options, const RunContext& ctx) {
  options.validate();
  std::error_code ignored;
  if (std::filesystem::equivalent(path, output, ignored)) {
    throw UsageError(
        {.what = "the repaired file would replace the original '" + path.string() + "'",
         .remedy = "Give another file with -o"});
  }
  if (detect_session_format(path) != SessionFormat::c3d) {
    throw UsageError(
        {.what = "'" + path.string() + "' is no C3D file; only C3D files are repaired"});
  }
  C3dRepairResult result{.file = path.string(), .output = output.string()};
  const std::string bytes = read_file(path);
  const std::string repaired = repaired_bytes(bytes, path.string(), options.read.c3d, result);
  ctx.check_cancelled();
  write_file(output, repaired);
  result.after = check_session(output, options, ctx.part(0.6, 1.0, "checking"));
  if (!result.copied) list_mends(result);
  return result;
}

std::string repair_text(const C3dRepairResult& r) {
  std::string text = r.file + " -> " + r.output + "\n";
  if (r.copied) text += "  Nothing needs repair; the output is a copy of the original.\n";
  if (!r.mended.empty()) text += "  Mended:\n";
  for (const C3dMend& m : r.mended) {
    text += "    " + m.finding.code + "  " + said(m.finding) + "\n            " + m.done + "\n";
  }
  if (!r.copied) {
    text += "  Kept: " + count_of(r.frames, "frame") + ", " + count_of(r.samples, "sample");
    text +=
        r.data_verbatim
            ? (r.gaps_marked == 0 ? ", all with the values they had.\n"
                                  : "; " + count_of(r.gaps_marked, "unusable sample") +
                                        " marked as gaps, all others with the values they had.\n")
            : "; the data section was written anew, and " + count_of(r.changed, "value") +
                  (r.changed == 1 ? " differs.\n" : " differ.\n");
    if (r.frames_lost > 0) {
      text += "  Lost: " + count_of(r.frames_lost, "frame") +
              " that the original announces but does not hold.\n";
    }
  }
  return text + "The repaired file:\n" + check_text(r.after);
}

std::string repair_json(const C3dRepairResult& r) {
  using Json = nlohmann::ordered_json;
  Json mended = Json::array();
  for (const C3dMend& m : r.mended) {
    mended.push_back({{"code", m.finding.code},
                      {"place", m.finding.place},
                      {"message", m.finding.message},
                      {"done", m.done}});
  }
  Json json = {{"file", r.file},
               {"output", r.output},
               {"copied", r.copied},
               {"mended", std::move(mended)},
               {"frames", r.frames},
               {"frames_lost", r.frames_lost},
               {"samples", r.samples},
               {"gaps_marked", r.gaps_marked},
               {"values_changed", r.changed},
               {"data_verbatim", r.data_verbatim},
               {"healthy", r.healthy()},
               {"after", Json::parse(check_json({r.after}))["files"][0]}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace kinemesh
