#include "report/gap_chart.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "config/text.h"
#include "report/chart.h"
#include "report/chart_axes.h"

namespace kinemesh {
namespace {

// What one row adds up to.
struct RowSum {
  std::size_t frames = 0;   // not measured
  std::size_t longest = 0;  // frames of the longest stretch without measurement
};

GapInterval within(const GapInterval& gap, std::size_t frames) {
  return {std::min(gap.begin, frames), std::min(gap.end, frames), gap.kind};
}

bool is_missing(const GapChart& chart, const GapInterval& gap) {
  return gap.kind >= chart.kinds.size() || !chart.kinds[gap.kind].measured;
}

// Touching intervals of different kinds are one stretch without measurement.
RowSum sum_of(const GapChart::Row& row, const GapChart& chart) {
  std::vector<GapInterval> gaps;
  for (const GapInterval& gap : row.gaps) {
    const GapInterval cut = within(gap, chart.frame_count);
    if (cut.begin < cut.end && is_missing(chart, gap)) gaps.push_back(cut);
  }
  std::sort(gaps.begin(), gaps.end(),
            [](const auto& a, const auto& b) { return a.begin < b.begin; });
  RowSum sum;
  std::size_t begin = 0;
  std::size_t end = 0;
  const auto close = [&] {
    sum.frames += end - begin;
    sum.longest = std::max(sum.longest, end - begin);
  };
  for (const GapInterval& gap : gaps) {
    if (gap.begin > end) {
      close();
      begin = gap.begin;
    }
    end = std::max(end, gap.end);
  }
  close();
  return sum;
}

struct Layout {
  double row_height, font;
  Box rows;      // the area of the bars
  Box together;  // the chart of how many are missing at once
  double height;
};

class GapChartPainter {
 public:
  GapChartPainter(const GapChart& chart, double width) : chart_(chart) {
    for (const auto& row : chart.markers) sums_.push_back(sum_of(row, chart));
    order_.resize(chart.markers.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    if (chart.order == GapChart::Order::worst_first) {
      std::stable_sort(order_.begin(), order_.end(), [this](std::size_t a, std::size_t b) {
        return sums_[a].frames > sums_[b].frames;
      });
    }
    for (const GapStyle& kind : chart.kinds) legend_.push_back({kind.label, kind.colour});
    legend_.insert(legend_.begin(), {"measured", measured()});
    lay_out(width);
  }

  Canvas draw() {
    Canvas canvas(width_, layout_.height);
    draw_heading(canvas);
    draw_together(canvas);
    draw_rows(canvas);
    chart::draw_x_axis(canvas, layout_.rows, scale_, axis(), false);
    return canvas;
  }

 private:
  static Colour measured() { return colour_from_hex(0xd5dee7); }

  bool timed() const { return chart_.rate_hz > 0.0; }
  Axis axis() const {
    return timed() ? Axis{.label = "time", .unit = "s"} : Axis{.label = "frame", .integer = true};
  }
  double x_of(std::size_t frame) const {
    const auto f = static_cast<double>(frame);
    return scale_(timed() ? f / chart_.rate_hz : f + static_cast<double>(chart_.first_frame));
  }

  void lay_out(double width) {
    width_ = std::max(width, 480.0);
    const std::size_t count = chart_.markers.size();
    layout_.row_height = count <= 60 ? 17.0 : count <= 120 ? 14.0 : 12.5;
    layout_.font = count <= 60 ? 11.0 : count <= 120 ? 10.0 : 9.5;
    double labels = 40.0;
    for (const auto& row : chart_.markers) {
      labels = std::max(labels, text_width(row.label, {.size = layout_.font}));
    }
    labels = std::min(labels, 0.25 * width_) + 22.0;
    label_width_ = labels - 20.0;
    const double right = 128.0;  // two columns of numbers
    double y = chart_.subtitle.empty() ? 38.0 : 58.0;
    legend_y_ = y;
    y += legend_height(width_ - 28.0, legend_) + 26.0;
    layout_.together = {labels, y, width_ - labels - right, 56.0};
    y += layout_.together.height + 14.0;
    const double rows = layout_.row_height * static_cast<double>(std::max<std::size_t>(count, 1));
    layout_.rows = {labels, y, width_ - labels - right, rows};
    layout_.height = std::ceil(y + rows + chart::x_axis_height(axis()) + 8.0);
    const auto frames = static_cast<double>(std::max<std::size_t>(chart_.frame_count, 1));
    scale_ = {0.0, frames, layout_.rows.x, layout_.rows.right()};
    if (timed()) {
      scale_.high = frames / chart_.rate_hz;
    } else {
      scale_.low = static_cast<double>(chart_.first_frame);
      scale_.high = scale_.low + frames;
    }
  }

  void draw_heading(Canvas& canvas) {
    canvas.text_within({14, 12}, chart_.title, width_ - 28,
                       {.size = 17, .bold = true, .anchor = TextAnchor::top});
    canvas.text_within({14, 36}, chart_.subtitle, width_ - 28,
                       {.size = 12, .colour = muted_colour, .anchor = TextAnchor::top});
    draw_legend(canvas, {14, legend_y_}, width_ - 28.0, legend_);
  }

  // How many markers are not measured in each column of pixels.
  void draw_together(Canvas& canvas) {
    const Box& box = layout_.together;
    const std::vector<double> counts = missing_at_once();
    const double most = std::max(1.0, *std::max_element(counts.begin(), counts.end()));
    const Ticks ticks = nice_ticks(0.0, most, 3, true);
    const double top = std::max(most, ticks.values.back());
    canvas.text({box.x, box.y - 6.0}, "markers not measured at once",
                {.size = 11.0, .colour = muted_colour});
    for (const double value : ticks.values) {
      const double y = box.bottom() - box.height * value / top;
      canvas.line({box.x, y}, {box.right(), y}, {.colour = grid_colour});
      canvas.text({box.x - 6.0, y}, tick_label(value, 0),
                  {.size = 10.0,
                   .colour = muted_colour,
                   .align = TextAlign::right,
                   .anchor = TextAnchor::middle});
    }
    std::vector<Box> columns;
    const double step = box.width / static_cast<double>(counts.size());
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const double height = box.height * counts[i] / top;
      if (height > 0.0) {
        columns.push_back(
            {box.x + step * static_cast<double>(i), box.bottom() - height, step, height});
      }
    }
    canvas.rectangles(std::move(columns), colour_from_hex(0x6b7c8f));
  }

  std::vector<double> missing_at_once() const {
    const std::size_t frames = std::max<std::size_t>(chart_.frame_count, 1);
    std::vector<int> change(frames + 1, 0);
    for (const auto& row : chart_.markers) {
      for (const GapInterval& gap : row.gaps) {
        const GapInterval cut = within(gap, chart_.frame_count);
        if (cut.begin >= cut.end || !is_missing(chart_, gap)) continue;
        ++change[cut.begin];
        --change[cut.end];
      }
    }
    const auto columns = std::min(frames, static_cast<std::size_t>(layout_.together.width));
    std::vector<double> most(std::max<std::size_t>(columns, 1), 0.0);
    int now = 0;
    for (std::size_t f = 0; f < frames; ++f) {
      now += change[f];
      double& column = most[f * most.size() / frames];
      column = std::max(column, static_cast<double>(now));
    }
    return most;
  }

  void draw_rows(Canvas& canvas) {
    const Box& area = layout_.rows;
    const double bar = layout_.row_height - (layout_.row_height > 15.0 ? 5.0 : 3.0);
    std::vector<Box> measured_bars;
    std::vector<std::vector<Box>> bars(chart_.kinds.size());
    for (std::size_t place = 0; place < order_.size(); ++place) {
      const double y = area.y + layout_.row_height * static_cast<double>(place);
      measured_bars.push_back({area.x, y, area.width, bar});
      for (const GapInterval& gap : chart_.markers[order_[place]].gaps) {
        const GapInterval cut = within(gap, chart_.frame_count);
        if (cut.begin >= cut.end || bars.empty()) continue;
        const std::size_t kind = gap.kind < bars.size() ? gap.kind : 0;
        const double from = x_of(cut.begin);
        const double wide = std::max(1.2, x_of(cut.end) - from);
        bars[kind].push_back({std::min(from, area.right() - wide), y, wide, bar});
      }
      draw_row_text(canvas, order_[place], y + 0.5 * bar);
    }
    canvas.rectangles(std::move(measured_bars), measured());
    for (std::size_t k = 0; k < bars.size(); ++k) {
      canvas.rectangles(std::move(bars[k]), chart_.kinds[k].colour);
    }
    draw_column_heads(canvas);
  }

  void draw_column_heads(Canvas& canvas) {
    const TextStyle head{.size = 10.0,
                         .colour = muted_colour,
                         .align = TextAlign::right,
                         .anchor = TextAnchor::bottom};
    canvas.text({layout_.rows.right() + 54.0, layout_.rows.y - 2.0}, "gaps", head);
    canvas.text({layout_.rows.right() + 116.0, layout_.rows.y - 2.0}, "longest", head);
  }

  void draw_row_text(Canvas& canvas, std::size_t marker, double y) {
    const RowSum& sum = sums_[marker];
    const bool whole = sum.frames == 0;
    TextStyle style{.size = layout_.font,
                    .colour = whole ? muted_colour : text_colour,
                    .align = TextAlign::right,
                    .anchor = TextAnchor::middle};
    const Box& area = layout_.rows;
    canvas.text_within({area.x - 8.0, y}, chart_.markers[marker].label, label_width_, style);
    if (whole) return;
    const double share = 100.0 * static_cast<double>(sum.frames) /
                         static_cast<double>(std::max<std::size_t>(chart_.frame_count, 1));
    canvas.text({area.right() + 54.0, y}, share < 0.05 ? "< 0.1 %" : format_fixed(share, 1) + " %",
                style);
    const auto longest = static_cast<double>(sum.longest);
    canvas.text(
        {area.right() + 116.0, y},
        timed() ? format_fixed(longest / chart_.rate_hz, 2) + " s" : std::to_string(sum.longest),
        style);
  }

  const GapChart& chart_;
  std::vector<RowSum> sums_;
  std::vector<std::size_t> order_;
  std::vector<LegendEntry> legend_;
  Layout layout_{};
  chart::Scale scale_;
  double width_ = 0.0, label_width_ = 0.0, legend_y_ = 0.0;
};

}  // namespace

std::vector<GapStyle> default_gap_styles() {
  return {{"missing", missing_colour},
          {"filled by spline", colour_from_hex(0x0072b2)},
          {"estimated from other markers", colour_from_hex(0xe69f00)},
          {"repaired", colour_from_hex(0x009e73)}};
}

Canvas draw_gap_chart(const GapChart& chart, double width) {
  return GapChartPainter(chart, width).draw();
}

double png_scale(const Canvas& canvas) {
  const double fits = std::sqrt(8e6 / (canvas.width() * canvas.height()));
  return std::clamp(std::floor(4.0 * fits) / 4.0, 1.0, 2.0);
}

}  // namespace kinemesh
