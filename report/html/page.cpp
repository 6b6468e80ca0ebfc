#include "report/html/page.h"

#include <array>

#include "config/input_file.h"
#include "config/output_file.h"
#include "report/clean_text.h"
#include "report/html/embedded_text.h"
#include "report/image.h"

namespace kinemesh {
namespace {

// Script text must not end its own element.
std::string script_text() {
  std::string text;
  for (const char* name : {"page.js", "viewer_data.js", "viewer_gl.js", "viewer.js"}) {
    text += embedded_text(name);
  }
  return "\"use strict\";\n" + text;
}

// The page runs this one script and no other, whatever a marker is called.
std::string policy(const std::string& script) {
  const std::string hex = sha256_of(script);
  std::string digest;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    digest += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-" +
         base64(digest) + "'";
}

}  // namespace

HtmlPage::HtmlPage(std::string title, std::string subtitle, std::string footer)
    : title_(std::move(title)), subtitle_(std::move(subtitle)), footer_(std::move(footer)) {}

HtmlSection& HtmlPage::add_section(std::string heading) {
  sections_.push_back(HtmlSection(context_, std::move(heading), context_.next_id("section")));
  return sections_.back();
}

std::string HtmlPage::html() const {
  const std::string script = script_text();
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  out += "<meta http-equiv=\"Content-Security-Policy\" content=\"" + policy(script) + "\">\n";
  out += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  out += "<title>" + escape_markup(title_) + "</title>\n";
  out += "<link rel=\"icon\" href=\"data:,\">\n";
  out += "<style>\n" + std::string(embedded_text("page.css")) + "</style>\n</head>\n<body>\n";
  out += "<a class=\"skip\" href=\"#content\">Skip to the content</a>\n<header>\n<h1>" +
         escape_markup(title_) + "</h1>\n";
  if (!subtitle_.empty()) out += "<p class=\"subtitle\">" + escape_markup(subtitle_) + "</p>\n";
  if (sections_.size() > 1) {
    out += "<nav aria-label=\"Sections\"><ul>\n";
    for (const HtmlSection& s : sections_) {
      out += "<li><a href=\"#" + s.id_ + "\">" + escape_markup(s.heading_) + "</a></li>\n";
    }
    out += "</ul></nav>\n";
  }
  out += "</header>\n<main id=\"content\">\n";
  for (const HtmlSection& s : sections_) {
    out += "<section id=\"" + s.id_ + "\">\n<h2>" + escape_markup(s.heading_) + "</h2>\n" +
           s.markup_ + "</section>\n";
  }
  out += "</main>\n";
  if (!footer_.empty()) out += "<footer><p>" + escape_markup(footer_) + "</p></footer>\n";
  out += "<script>" + script + "</script>\n</body>\n</html>\n";
  return out;
}

void HtmlPage::write(const std::filesystem::path& path) const { write_file(path, html()); }

}  // namespace kinemesh
