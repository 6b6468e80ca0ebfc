#include "report/html/mesh_viewer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "config/error.h"
#include "config/text.h"
#include "report/chart.h"
#include "report/clean_text.h"
#include "report/image.h"

namespace kinemesh {
namespace {

using nlohmann::json;

constexpr const char* hint =
    "Drag or arrow keys turn, + and − zoom, space plays, comma and full stop step.";

json vector_json(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

// JSON that may stand inside a script element: no "</script>" and no "<!--" can occur in it.
std::string script_json(const json& value) {
  std::string out;
  for (const char c : value.dump(-1, ' ', false, json::error_handler_t::replace)) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

struct Ball {
  Eigen::Vector3f centre;
  float radius;
};

// Around the mesh in every frame, seen from any side: the middle of its bounds and, a little short
// of it because corners rarely point across the view, the farthest vertex.
Ball bounds_of(const AnimatedMesh& animation) {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
  Eigen::Vector3f high = -low;
  const std::size_t step = animation.frame_count() / 500 + 1;
  for (std::size_t f = 0; f < animation.frame_count(); f += step) {
    const FrameView frame = animation.frame(f);
    low = low.cwiseMin(frame.colwise().minCoeff().transpose());
    high = high.cwiseMax(frame.colwise().maxCoeff().transpose());
  }
  Ball ball{0.5F * (low + high), 0.0F};
  for (std::size_t f = 0; f < animation.frame_count(); f += step) {
    const FrameView frame = animation.frame(f);
    ball.radius = std::max(ball.radius,
                           (frame.rowwise() - ball.centre.transpose()).rowwise().norm().maxCoeff());
  }
  ball.radius = std::max(0.95F * ball.radius, 1e-6F);
  return ball;
}

// vertex, first frame, one past the last, for every stretch of estimated samples.
json filled_json(const AnimatedMesh& animation) {
  json list = json::array();
  const std::size_t vertices = animation.vertex_count();
  const auto filled = animation.filled();
  if (filled.empty()) return list;
  for (std::size_t v = 0; v < vertices; ++v) {
    for (std::size_t f = 0; f < animation.frame_count(); ++f) {
      if (filled[f * vertices + v] == 0) continue;
      const std::size_t begin = f;
      while (f < animation.frame_count() && filled[f * vertices + v] != 0) ++f;
      list.insert(list.end(), {v, begin, f});
    }
  }
  return list;
}

struct CodedField {
  json about;
  std::string bytes;
};

CodedField code_field(const ViewerField& field, const AnimatedMesh& animation, std::size_t room) {
  const std::size_t vertices = animation.vertex_count();
  const std::size_t frames = field.values.size() / vertices;
  if (field.values.size() != frames * vertices ||
      (frames != 1 && frames != animation.frame_count())) {
    throw InternalError("a field of a 3D view has neither one value per vertex nor per sample");
  }
  CodedField coded;
  // Keys as in the code of the animation: evenly from the first frame to the last.
  const std::size_t keys = std::clamp<std::size_t>(room / vertices, 1, frames);
  const double step =
      keys > 1 ? static_cast<double>(frames - 1) / static_cast<double>(keys - 1) : 1.0;
  const double span = field.scale.high - field.scale.low;
  for (std::size_t key = 0; key < keys; ++key) {
    const auto frame = static_cast<std::size_t>(std::lround(static_cast<double>(key) * step));
    for (std::size_t v = 0; v < vertices; ++v) {
      const double value = field.values[frame * vertices + v];
      const double t = span > 0.0 ? std::clamp((value - field.scale.low) / span, 0.0, 1.0) : 0.0;
      coded.bytes +=
          static_cast<char>(static_cast<uint8_t>(std::isnan(value) ? 255 : std::lround(254.0 * t)));
    }
  }
  std::string table;
  for (int i = 0; i < 256; ++i) {
    const double value =
        i == 255 ? std::numeric_limits<double>::quiet_NaN() : field.scale.low + span * i / 254.0;
    const Colour c = field.scale(value);
    for (const double part : {c.r, c.g, c.b}) {
      table += static_cast<char>(static_cast<uint8_t>(std::lround(255.0 * part)));
    }
  }
  const int decimals =
      span > 0.0 ? std::clamp(2 - static_cast<int>(std::floor(std::log10(span))), 0, 6) : 2;
  coded.about = {{"label", clean_text(with_unit(field.scale.label, field.scale.unit))},
                 {"lowText", tick_label(field.scale.low, decimals)},
                 {"highText", tick_label(field.scale.high, decimals)},
                 {"table", base64(table)},
                 {"keys", keys},
                 {"keyStep", step}};
  return coded;
}

std::string face_words(const Topology& topology, bool wide) {
  std::string bytes;
  for (const Triangle& face : topology.faces()) {
    for (const VertexIndex v : face) {
      const std::array<uint16_t, 2> halves = {static_cast<uint16_t>(v & 0xFFFFU),
                                              static_cast<uint16_t>(v >> 16U)};
      bytes.append(reinterpret_cast<const char*>(halves.data()), wide ? 4 : 2);
    }
  }
  return bytes;
}

std::string button(std::string_view part, std::string_view text, bool pressable = false) {
  return "<button type=\"button\" data-part=\"" + std::string(part) + "\"" +
         (pressable ? " aria-pressed=\"false\"" : "") + ">" + std::string(text) + "</button>\n";
}

}  // namespace

MeshViewer::MeshViewer(const AnimatedMesh& animation, MeshViewerOptions options,
                       const RunContext& ctx)
    : title_(std::move(options.title)),
      named_(animation.vertex_names.size() == animation.vertex_count()),
      has_filled_(!animation.filled().empty()) {
  code_ = encode_animation(animation, options.code, ctx);
  const Topology& topology = animation.topology();
  const bool wide = topology.vertex_count() > 65536;
  std::string bytes = code_.bytes + face_words(topology, wide);
  json fields = json::array();
  for (const ViewerField& field : options.fields) {
    CodedField coded = code_field(field, animation, options.code.max_bytes / 3);
    fields.push_back(std::move(coded.about));
    bytes += coded.bytes;
    colour_controls_ += "<option value=\"" + std::to_string(fields.size() - 1) + "\"" +
                        (fields.size() == options.fields.size() ? " selected" : "") + ">" +
                        escape_markup(field.scale.label) + "</option>\n";
  }
  data_ = base64(bytes);
  const BodyAxes axes = options.axes ? *options.axes : estimate_axes(topology, animation.frame(0));
  const Ball ball = bounds_of(animation);
  json about = {{"vertices", animation.vertex_count()},
                {"faces", topology.face_count()},
                {"longIndices", wide},
                {"frames", animation.frame_count()},
                {"firstFrame", animation.first_frame},
                {"rate", animation.rate_hz},
                {"keys", code_.keys},
                {"keyStep", code_.key_step},
                {"modeCount", code_.scales.size()},
                {"scales", code_.scales},
                {"centre", vector_json(ball.centre)},
                {"radius", ball.radius},
                {"front", vector_json(axes.front)},
                {"up", vector_json(axes.up)},
                {"fields", fields},
                {"filled", filled_json(animation)},
                {"group", clean_text(options.group)},
                {"hint", hint}};
  if (!options.timeline.empty()) about["timeline"] = options.timeline;
  if (named_) {
    for (const std::string& name : animation.vertex_names) {
      about["names"].push_back(clean_text(name));
    }
  }
  about_ = script_json(about);
  statement_ =
      "Compressed for this page: " +
      count_of(code_.scales.size(), "mode of motion", "modes of motion") +
      (code_.key_step > 1 ? ", one key every " + format_fixed(code_.key_step, 1) + " frames"
                          : std::string(", every frame")) +
      "; the error is at most " + format_fixed(code_.max_error_mm, 3) + " mm, RMS " +
      format_fixed(code_.rms_error_mm, 3) + " mm.";
}

std::string MeshViewer::statement() const { return statement_; }

std::string MeshViewer::render(HtmlContext& context) const {
  const std::string id = context.next_id("view");
  const std::string name = title_.empty() ? "3D view" : title_;
  std::string out = "<div class=\"viewer\" id=\"" + id + "\">\n<div class=\"stage\">\n";
  out += "<canvas data-part=\"canvas\" tabindex=\"0\" role=\"application\" aria-label=\"" +
         escape_markup(name) + ". " + hint + "\"></canvas>\n";
  out += "<div class=\"title\">" + escape_markup(title_) + "</div>\n";
  out += "<div class=\"hint\" data-part=\"hint\">" + std::string(hint) + "</div>\n</div>\n";
  out += "<div class=\"controls\">\n" + button("play", "Play", true);
  out +=
      "<div class=\"time\"><input data-part=\"slider\" type=\"range\" min=\"0\" max=\"0\" "
      "step=\"1\" value=\"0\" aria-label=\"Time\"><output data-part=\"output\"></output></div>\n";
  out +=
      "<select data-part=\"speed\" aria-label=\"Speed\"><option value=\"0.25\">¼ speed</option>"
      "<option value=\"0.5\">½ speed</option><option value=\"1\" selected>real time</option>"
      "</select>\n";
  out += button("front", "Front") + button("side", "Side") + button("oblique", "Oblique");
  out += button("edges", "Edges", true) + button("points", "Vertices", true);
  if (has_filled_) out += "<span class=\"key\">filled</span>\n";
  out += "</div>\n";
  if (!colour_controls_.empty()) {
    out += "<div class=\"scale\" data-part=\"scale\"><label>Colour <select data-part=\"field\">\n" +
           colour_controls_ +
           "<option value=\"-1\">none</option>\n</select></label> <span class=\"name\"></span> "
           "<span class=\"range\"><span class=\"low\"></span><span class=\"bar\"></span>"
           "<span class=\"high\"></span></span></div>\n";
  }
  out += "<script type=\"application/json\" data-part=\"about\">" + about_ + "</script>\n";
  out += "<script type=\"text/plain\" data-part=\"data\">" + data_ + "</script>\n</div>\n";
  return out + "<p class=\"muted\">" + escape_markup(statement_) + "</p>\n";
}

}  // namespace kinemesh
