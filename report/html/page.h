// Single-file HTML reports that work offline: style, scripts and data are inside, and the page's
// own policy forbids loading anything else. Readable at 380 px, printable on A4.
#pragma once

#include <deque>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace kinemesh {

/// What components need from the page that they are put into.
class HtmlContext {
 public:
  /// An id that is unique on the page: "chart-3".
  std::string next_id(std::string_view kind) {
    return std::string(kind) + "-" + std::to_string(++count_);
  }

 private:
  int count_ = 0;
};

/// A heading and the components below it.
class HtmlSection {
 public:
  /// A component is anything with `std::string render(HtmlContext&) const` that returns safe
  /// markup (report/html/components.h).
  template <class Component>
  HtmlSection& add(const Component& component) {
    markup_ += component.render(*context_);
    return *this;
  }
  /// Components beside each other where the page is wide enough, otherwise below each other.
  template <class... Component>
  HtmlSection& add_beside(const Component&... components) {
    markup_ += "<div class=\"beside\">\n";
    ((markup_ += "<div>" + components.render(*context_) + "</div>\n"), ...);
    markup_ += "</div>\n";
    return *this;
  }

 private:
  friend class HtmlPage;
  HtmlSection(HtmlContext& context, std::string heading, std::string id)
      : context_(&context), heading_(std::move(heading)), id_(std::move(id)) {}
  HtmlContext* context_;
  std::string heading_, id_, markup_;
};

/// All texts may hold any bytes; they are escaped here and in the components.
class HtmlPage {
 public:
  /// `subtitle` and `footer` may be empty.
  explicit HtmlPage(std::string title, std::string subtitle = {}, std::string footer = {});
  HtmlPage(const HtmlPage&) = delete;
  HtmlPage& operator=(const HtmlPage&) = delete;

  /// The section stays where it is while others are added.
  HtmlSection& add_section(std::string heading);

  std::string html() const;
  /// Writes html() whole or not at all. Throws InputError when it cannot be written.
  void write(const std::filesystem::path& path) const;

 private:
  std::string title_, subtitle_, footer_;
  HtmlContext context_;
  std::deque<HtmlSection> sections_;
};

}  // namespace kinemesh
