#include "capture/formats/frame_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::size_t none = PointColumns::none;

struct Row {
  std::size_t line = 0;
  int64_t frame = 0;
  double time = 0.0;
};

class TableReader {
 public:
  TableReader(const TableText& text, const FrameTable& table, const TableReadOptions& options,
              const RunContext& ctx)
      : text_(text), table_(table), options_(options), ctx_(ctx) {}

  MarkerSequence read() {
    collect_rows();
    const int64_t step = frame_step();
    const auto frame_count =
        static_cast<std::size_t>((rows_.back().frame - rows_.front().frame) / step) + 1;
    if (frame_count > 4 * rows_.size() + 1000) {
      text_.refuse(rows_.back().line,
                   "frame " + std::to_string(rows_.back().frame) + " follows far too late");
    }
    std::vector<Marker> markers;
    markers.reserve(table_.points.size());
    for (const PointColumns& p : table_.points) markers.push_back(p.marker);
    MarkerSequence take = MarkerSequence::invalid(frame_count, std::move(markers), rate());
    take.first_frame = rows_.front().frame + table_.frame_number_offset;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (r % 1024 == 0) {
        ctx_.check_cancelled();
        ctx_.progress(static_cast<double>(r) / static_cast<double>(rows_.size()));
      }
      const int64_t since = rows_[r].frame - rows_.front().frame;
      fill(rows_[r].line, static_cast<std::size_t>(since / step), take);
    }
    ctx_.progress(1.0);
    if (table_.declared_frames != 0 && table_.declared_frames != frame_count) {
      ctx_.warn(text_.file() + ": the header announces " +
                count_of(table_.declared_frames, "frame") + ", the table holds " +
                std::to_string(frame_count));
    }
    return take;
  }

 private:
  std::size_t widest_column() const {
    std::size_t widest = 0;
    for (const PointColumns& p : table_.points) {
      widest = std::max(widest, *std::ranges::max_element(p.xyz));
    }
    return widest;
  }

  void collect_rows() {
    const std::size_t widest = widest_column();
    for (std::size_t line = table_.first_line; line < text_.size(); ++line) {
      if (trim(text_[line]).find_first_not_of(" \t,;") == std::string_view::npos) continue;
      split_cells(text_[line], table_.separator, cells_);
      if (line + 1 == text_.size() && text_.unfinished() && cells_.size() <= widest) {
        ctx_.warn(text_.file() + ": line " + std::to_string(line + 1) +
                  ": the file is cut off here; this frame is left out");
        break;
      }
      Row row{.line = line, .frame = static_cast<int64_t>(rows_.size()) + 1};
      if (table_.frame_column != none) row.frame = frame_number(line);
      if (table_.time_column != none) row.time = time(line);
      if (!rows_.empty() && row.frame <= rows_.back().frame) {
        text_.refuse(line,
                     "frame " + std::to_string(row.frame) + " follows frame " +
                         std::to_string(rows_.back().frame),
                     "Frame numbers must ascend");
      }
      rows_.push_back(row);
    }
    if (rows_.empty()) {
      text_.refuse(std::min(table_.first_line, text_.size()), "the table holds no frame");
    }
  }

  int64_t frame_number(std::size_t line) const {
    const std::optional<double> value = table_.frame_column < cells_.size()
                                            ? parse_cell(cells_[table_.frame_column])
                                            : std::nullopt;
    if (!value || std::abs(*value) > 1e12 || std::floor(*value) != *value) {
      text_.refuse(line, "the frame number '" +
                             std::string(table_.frame_column < cells_.size()
                                             ? cells_[table_.frame_column].substr(0, 40)
                                             : "") +
                             "' is no whole number");
    }
    return static_cast<int64_t>(*value);
  }

  double time(std::size_t line) const {
    if (table_.time_column >= cells_.size()) text_.refuse(line, "the line has no time");
    const std::optional<double> value = parse_cell(cells_[table_.time_column]);
    if (!value || !std::isfinite(*value)) {
      text_.refuse(line, "the time '" + std::string(cells_[table_.time_column].substr(0, 40)) +
                             "' is no number");
    }
    return *value;
  }

  /// Exports at a reduced rate number only the frames that they keep.
  int64_t frame_step() const {
    int64_t step = 0;
    for (std::size_t r = 1; r < rows_.size(); ++r) {
      step = std::gcd(step, rows_[r].frame - rows_[r - 1].frame);
    }
    return std::max<int64_t>(step, 1);
  }

  double rate() const {
    const double span = rows_.back().time - rows_.front().time;
    double from_times = 0.0;
    if (table_.time_column != none && span > 0) {
      const auto steps = (rows_.back().frame - rows_.front().frame) / frame_step();
      from_times = static_cast<double>(steps) / span;
      if (std::abs(from_times - std::round(from_times)) < 2e-3 * from_times && from_times > 1) {
        from_times = std::round(from_times);  // times are rounded in the file
      }
    }
    if (table_.rate_hz > 0) {
      if (from_times > 0 && std::abs(from_times / table_.rate_hz - 1) > 0.02) {
        ctx_.warn(text_.file() + ": the header says " + format_number(table_.rate_hz) +
                  " Hz, the times say " + format_fixed(from_times, 2) + " Hz; the header is taken");
      }
      return table_.rate_hz;
    }
    if (from_times > 0) return from_times;
    if (options_.unstated.rate_hz > 0) return options_.unstated.rate_hz;
    text_.refuse(rows_.front().line, "the frame rate is not known",
                 "Say it with --rate, or export with the header or with a time column");
  }

  void fill(std::size_t line, std::size_t frame, MarkerSequence& take) {
    split_cells(text_[line], table_.separator, cells_);
    for (std::size_t m = 0; m < table_.points.size(); ++m) {
      const PointColumns& point = table_.points[m];
      std::array<float, 3> xyz{};
      if (!position(line, point, xyz)) continue;
      if (options_.zero_is_gap && point.valid == none &&
          point.marker.kind <= MarkerKind::virtual_point && xyz[0] == 0 && xyz[1] == 0 &&
          xyz[2] == 0) {
        continue;
      }
      const std::size_t sample = take.sample(frame, m);
      const double valid = optional_cell(line, point.valid, 1.0, point.marker);
      if (valid == 0) continue;
      std::ranges::copy(xyz, take.positions().begin() + static_cast<std::ptrdiff_t>(3 * sample));
      take.flags()[sample] = SampleFlag::valid;
      if (valid == 2) take.flags()[sample] |= SampleFlag::filled;
      take.residuals()[sample] =
          static_cast<float>(optional_cell(line, point.residual, 0.0, point.marker));
      if (point.uncertainty == none) continue;
      take.add_uncertainty();
      take.uncertainty()[sample] =
          static_cast<float>(optional_cell(line, point.uncertainty, 0.0, point.marker));
    }
  }

  std::string_view cell(std::size_t column) const {
    return column < cells_.size() ? cells_[column] : std::string_view();
  }

  [[noreturn]] void refuse(std::size_t line, const Marker& marker, const std::string& what) const {
    throw InputError({.what = what,
                      .file = text_.file(),
                      .place = "line " + std::to_string(line + 1),
                      .marker = qualified_label(marker.subject, marker.label)});
  }

  bool position(std::size_t line, const PointColumns& point, std::array<float, 3>& xyz) const {
    const double scale = point.marker.kind <= MarkerKind::virtual_point ? table_.millimetres : 1.0;
    int given = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string_view text = cell(point.xyz[k]);
      if (is_blank_cell(text)) continue;
      const std::optional<double> value = parse_cell(text);
      if (!value)
        refuse(line, point.marker, "'" + std::string(text.substr(0, 40)) + "' is no number");
      xyz[k] = static_cast<float>(*value * scale);
      if (std::isfinite(xyz[k])) ++given;
    }
    if (given != 0 && given != 3) refuse(line, point.marker, "some coordinates are missing");
    return given == 3;
  }

  double optional_cell(std::size_t line, std::size_t column, double otherwise,
                       const Marker& marker) const {
    if (column == none || is_blank_cell(cell(column))) return otherwise;
    const std::optional<double> value = parse_cell(cell(column));
    if (!value)
      refuse(line, marker, "'" + std::string(cell(column).substr(0, 40)) + "' is no number");
    return *value;
  }

  const TableText& text_;
  const FrameTable& table_;
  const TableReadOptions& options_;
  const RunContext& ctx_;
  std::vector<Row> rows_;
  std::vector<std::string_view> cells_;
};

}  // namespace

MarkerSequence read_frame_table(const TableText& text, const FrameTable& table,
                                const TableReadOptions& options, const RunContext& ctx) {
  if (table.points.empty()) {
    text.refuse(std::min(table.first_line, text.size()), "the table names no marker");
  }
  return TableReader(text, table, options, ctx).read();
}

}  // namespace kinemesh
