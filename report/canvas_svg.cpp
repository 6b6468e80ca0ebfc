// A Canvas as SVG 1.1 with real text, so that it stays small, searchable and accessible.
#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "report/clean_text.h"
#include "report/drawing.h"

namespace kinemesh::drawing {
namespace {

class SvgWriter {
 public:
  explicit SvgWriter(std::string_view id_prefix) : prefix_(id_prefix) {}

  // Two decimals are a fiftieth of what a screen resolves.
  void number(double value) {
    if (!std::isfinite(value)) value = 0.0;
    value = std::round(value * 100.0) / 100.0;
    if (value == 0.0) value = 0.0;  // never "-0"
    std::array<char, 64> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    out_.append(digits.data(), end);
  }
  void attribute(std::string_view name, double value) {
    out_ += ' ';
    out_ += name;
    out_ += "=\"";
    number(value);
    out_ += '"';
  }
  void colour(std::string_view name, const Colour& c) {
    static constexpr std::string_view hex = "0123456789abcdef";
    out_ += ' ';
    out_ += name;
    out_ += "=\"#";
    for (const double part : {c.r, c.g, c.b}) {
      const auto level = static_cast<unsigned>(std::lround(std::clamp(part, 0.0, 1.0) * 255.0));
      out_ += hex[level >> 4U];
      out_ += hex[level & 15U];
    }
    out_ += '"';
    if (c.a < 1.0) attribute(std::string(name) + "-opacity", c.a);
  }
  void point(const Eigen::Vector2d& p) {
    number(p.x());
    out_ += ' ';
    number(p.y());
  }

  void operator()(const Rectangles& r) {
    if (r.boxes.size() == 1) {
      const Box& b = r.boxes.front();
      out_ += "<rect";
      attribute("x", b.x);
      attribute("y", b.y);
      attribute("width", std::max(0.0, b.width));
      attribute("height", std::max(0.0, b.height));
    } else {
      out_ += "<path d=\"";
      for (const Box& b : r.boxes) {
        out_ += 'M';
        point({b.x, b.y});
        out_ += 'h';
        number(b.width);
        out_ += 'v';
        number(b.height);
        out_ += 'h';
        number(-b.width);
        out_ += 'z';
      }
      out_ += '"';
    }
    colour("fill", r.fill);
    out_ += "/>\n";
  }

  void operator()(const Path& p) {
    out_ += "<path d=\"";
    for (std::size_t i = 0; i < p.points.size(); ++i) {
      const bool begins = p.pairs ? i % 2 == 0 : i == 0;
      out_ += begins ? 'M' : 'L';
      point(p.points[i]);
    }
    if (p.closed) out_ += 'z';
    out_ += '"';
    if (p.closed) {
      colour("fill", p.stroke.colour);
    } else {
      out_ += " fill=\"none\" stroke-linejoin=\"round\"";
      colour("stroke", p.stroke.colour);
      attribute("stroke-width", p.stroke.width);
      dashes(p.stroke);
    }
    out_ += "/>\n";
  }

  void operator()(const Circle& c) {
    out_ += "<circle";
    attribute("cx", c.centre.x());
    attribute("cy", c.centre.y());
    attribute("r", c.radius);
    colour("fill", c.fill);
    out_ += "/>\n";
  }

  void operator()(const Text& t) {
    const double down = baseline_offset(t.style);
    out_ += "<text";
    if (t.style.angle != 0.0) {
      out_ += " transform=\"translate(";
      point(t.at);
      out_ += ") rotate(";
      number(-t.style.angle);
      out_ += ")\"";
      attribute("y", down);
    } else {
      attribute("x", t.at.x());
      attribute("y", t.at.y() + down);
    }
    attribute("font-size", t.style.size);
    if (t.style.bold) out_ += " font-weight=\"bold\"";
    if (t.style.align == TextAlign::centre) out_ += " text-anchor=\"middle\"";
    if (t.style.align == TextAlign::right) out_ += " text-anchor=\"end\"";
    colour("fill", t.style.colour);
    out_ += '>' + escape_markup(t.text) + "</text>\n";
  }

  void operator()(const Picture& p) {
    out_ += "<image";
    attribute("x", p.box.x);
    attribute("y", p.box.y);
    attribute("width", p.box.width);
    attribute("height", p.box.height);
    out_ += " preserveAspectRatio=\"none\" href=\"data:image/png;base64," +
            base64(encode_png(p.image)) + "\"/>\n";
  }

  void operator()(const BeginClip& c) {
    const std::string id = prefix_ + "-clip" + std::to_string(clips_++);
    out_ += "<clipPath id=\"" + id + "\"><rect";
    attribute("x", c.box.x);
    attribute("y", c.box.y);
    attribute("width", c.box.width);
    attribute("height", c.box.height);
    out_ += "/></clipPath>\n<g clip-path=\"url(#" + id + ")\">\n";
    ++open_;
  }

  void operator()(const EndClip& /*end*/) {
    if (open_ == 0) return;
    out_ += "</g>\n";
    --open_;
  }

  void begin(double width, double height, const SvgText& text) {
    out_ += "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\"";
    attribute("width", width);
    attribute("height", height);
    out_ += " viewBox=\"0 0 ";
    point({width, height});
    out_ += "\" font-family=\"'DejaVu Sans', Verdana, sans-serif\">\n";
    if (!text.title.empty()) out_ += "<title>" + escape_markup(text.title) + "</title>\n";
    if (!text.description.empty()) {
      out_ += "<desc>" + escape_markup(text.description) + "</desc>\n";
    }
  }

  std::string end() {
    while (open_ > 0) (*this)(EndClip{});
    out_ += "</svg>\n";
    return std::move(out_);
  }

 private:
  void dashes(const Stroke& stroke) {
    if (stroke.dash.empty()) return;
    out_ += " stroke-dasharray=\"";
    for (const double length : stroke.dash) {
      number(length);
      out_ += ' ';
    }
    out_.back() = '"';
  }

  std::string out_;
  std::string prefix_;
  int clips_ = 0;
  int open_ = 0;
};

}  // namespace

std::string to_svg(double width, double height, const std::vector<Operation>& operations,
                   const SvgText& text, std::string_view id_prefix) {
  SvgWriter writer(id_prefix);
  writer.begin(width, height, text);
  for (const Operation& operation : operations) std::visit(writer, operation);
  return writer.end();
}

}  // namespace kinemesh::drawing
