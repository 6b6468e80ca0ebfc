#include "report/html/components.h"

#include "report/clean_text.h"

namespace kinemesh {
namespace {

std::string element(std::string_view name, std::string_view text,
                    std::string_view attributes = {}) {
  std::string out = "<";
  out += name;
  out += attributes;
  out += '>' + escape_markup(text) + "</";
  out += name;
  return out + ">";
}

std::string fold(bool folded, const std::string& summary, const std::string& content) {
  if (!folded) return content;
  return "<details><summary>" + escape_markup(summary) + "</summary>\n" + content + "</details>\n";
}

// Wide content scrolls in a box of its own, which the keyboard reaches too.
std::string scrollable(std::string_view name, const std::string& content) {
  return "<div class=\"scroll\" tabindex=\"0\" role=\"group\" aria-label=\"" + escape_markup(name) +
         "\">\n" + content + "</div>\n";
}

}  // namespace

std::string Paragraph::render(HtmlContext& /*context*/) const {
  return element("p", text, muted ? " class=\"muted\"" : "") + "\n";
}

std::string WarningList::render(HtmlContext& /*context*/) const {
  if (warnings.empty()) return element("p", none, " class=\"no-warnings\"") + "\n";
  std::string out = "<ul class=\"warnings\">\n";
  for (const std::string& warning : warnings) out += element("li", warning) + "\n";
  return out + "</ul>\n";
}

std::string Figures::render(HtmlContext& /*context*/) const {
  std::string out = "<ul class=\"figures\">\n";
  for (const Entry& entry : entries) {
    out += "<li>" + element("strong", entry.value) + " " + element("span", entry.label) + "</li>\n";
  }
  return out + "</ul>\n";
}

std::string KeyValues::render(HtmlContext& /*context*/) const {
  std::string out = "<dl>\n";
  for (const auto& [key, value] : entries) {
    out += element("dt", key) + element("dd", value) + "\n";
  }
  return out + "</dl>\n";
}

std::string Table::render(HtmlContext& /*context*/) const {
  std::string body = "<table>\n";
  if (!caption.empty() && !folded) body += element("caption", caption) + "\n";
  body += "<thead><tr>";
  for (const Column& column : columns) {
    body += element("th", column.heading,
                    column.number ? " scope=\"col\" class=\"number\"" : " scope=\"col\"");
  }
  body += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    body += "<tr>";
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const std::string_view cell = c < row.size() ? std::string_view(row[c]) : "";
      const bool fits = cell.size() <= 24;  // is not broken where paper is narrow
      body += element("td", cell,
                      columns[c].number ? " class=\"number\"" : (fits ? " class=\"short\"" : ""));
    }
    body += "</tr>\n";
  }
  body += "</tbody>\n</table>\n";
  return fold(folded, caption, scrollable(caption.empty() ? "Table" : caption, body));
}

std::string Figure::render(HtmlContext& context) const {
  const std::string id = context.next_id("chart");
  const std::string drawing =
      "<div class=\"drawing\" style=\"--least:" + std::to_string(static_cast<int>(least_width)) +
      "px;--phone:" + std::to_string(static_cast<int>(canvas.width())) + "px\">\n" +
      canvas.svg({.title = title}, id) + "</div>\n";
  std::string out = "<figure>\n" + scrollable(title, drawing);
  if (!caption.empty()) out += element("figcaption", caption) + "\n";
  return fold(folded, title, out + "</figure>\n");
}

std::string Picture::render(HtmlContext& /*context*/) const {
  std::string out = "<figure><img alt=\"" + escape_markup(title) + "\" width=\"" +
                    std::to_string(image.width) + "\" height=\"" + std::to_string(image.height) +
                    "\" src=\"data:image/png;base64," + base64(encode_png(image)) + "\">\n";
  if (!caption.empty()) out += element("figcaption", caption) + "\n";
  return out + "</figure>\n";
}

std::string CodeBlock::render(HtmlContext& context) const {
  const std::string id = context.next_id("code");
  const std::string content =
      "<div class=\"code\"><button type=\"button\" class=\"copy\" data-copy=\"" + id +
      "\">Copy</button>\n<pre id=\"" + id + "\" tabindex=\"0\">" + escape_lines(text) +
      "</pre></div>\n";
  if (folded) return fold(true, caption, content);
  return (caption.empty() ? "" : element("h3", caption) + "\n") + content;
}

}  // namespace kinemesh
