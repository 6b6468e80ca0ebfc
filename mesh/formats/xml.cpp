#include "mesh/formats/xml.h"

#include <algorithm>
#include <array>

#include "config/error.h"

namespace kinemesh {
namespace {

constexpr std::array<std::pair<std::string_view, char>, 5> entities{
    {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}}};

std::string unescaped(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto* const found =
        std::find_if(entities.begin(), entities.end(),
                     [&](const auto& entity) { return text.substr(i).starts_with(entity.first); });
    out += found == entities.end() ? text[i] : found->second;
    i += found == entities.end() ? 1 : found->first.size();
  }
  return out;
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

class Parser {
 public:
  Parser(std::string_view text, const std::string& name, std::string_view stop_at)
      : text_(text), name_(name), stop_at_(stop_at) {}

  XmlElement parse() {
    XmlElement document;
    std::vector<XmlElement> open{std::move(document)};  // the innermost is last
    while (!stopped_ && next_tag(open.back())) {
      if (skip_markup()) continue;
      if (text_.substr(at_).starts_with("</")) {
        close(open);
      } else {
        start(open);
      }
    }
    while (open.size() > 1) {
      if (!stopped_) fail("the element <" + open.back().name + "> is not closed");
      fold(open);
    }
    if (open.front().children.empty()) fail("there is no element");
    return std::move(open.front().children.front());
  }

 private:
  /// Moves to the next '<', adding the text before it; false at the end.
  bool next_tag(XmlElement& inside) {
    const std::size_t found = std::min(text_.find('<', at_), text_.size());
    const std::string_view run = text_.substr(at_, found - at_);
    if (run.size() > inside.text.size()) inside.text = run;
    at_ = found;
    return found < text_.size();
  }

  /// Comments, <?...?> and <!...>.
  bool skip_markup() {
    const std::string_view rest = text_.substr(at_);
    if (rest.starts_with("<!--")) return skip_past("-->");
    if (rest.starts_with("<?")) return skip_past("?>");
    if (rest.starts_with("<!")) return skip_past(">");
    return false;
  }

  bool skip_past(std::string_view end) {
    const std::size_t found = text_.find(end, at_);
    if (found == std::string_view::npos) fail("'" + std::string(end) + "' is missing");
    at_ = found + end.size();
    return true;
  }

  void close(std::vector<XmlElement>& open) {
    at_ += 2;
    const std::string_view closing = word();
    if (open.size() < 2 || open.back().name != closing) {
      fail("</" + std::string(closing.substr(0, 40)) + "> closes no open element");
    }
    skip_past(">");
    fold(open);
  }

  static void fold(std::vector<XmlElement>& open) {
    XmlElement done = std::move(open.back());
    open.pop_back();
    open.back().children.push_back(std::move(done));
  }

  void start(std::vector<XmlElement>& open) {
    ++at_;
    XmlElement element;
    element.name = word();
    if (element.name.empty()) fail("an element has no name");
    if (open.size() > 64) fail("the elements are nested too deeply");
    for (skip_space(); at_ < text_.size() && text_[at_] != '>' && text_[at_] != '/'; skip_space()) {
      read_attribute(element);
    }
    const bool empty = at_ < text_.size() && text_[at_] == '/';
    skip_past(">");
    element.text_begin = at_;
    if (empty) {
      open.back().children.push_back(std::move(element));
    } else if (!stop_at_.empty() && element.name == stop_at_) {
      element.text = text_.substr(at_);
      open.push_back(std::move(element));
      stopped_ = true;
    } else {
      open.push_back(std::move(element));
    }
  }

  void read_attribute(XmlElement& element) {
    std::string key(word());
    skip_space();
    if (key.empty() || at_ >= text_.size() || text_[at_] != '=') fail("an attribute has no value");
    ++at_;
    skip_space();
    const char quote = at_ < text_.size() ? text_[at_] : '\0';
    if (quote != '"' && quote != '\'') fail("the value of '" + key + "' is not quoted");
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos) fail("the value of '" + key + "' has no end");
    element.attributes.emplace_back(std::move(key),
                                    unescaped(text_.substr(at_ + 1, end - at_ - 1)));
    at_ = end + 1;
  }

  std::string_view word() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_]) && text_[at_] != '>' && text_[at_] != '/' &&
           text_[at_] != '=' && text_[at_] != '<') {
      ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }

  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }

  [[noreturn]] void fail(const std::string& what) const {
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size()));
    throw InputError({.what = what,
                      .file = name_,
                      .place = "line " + std::to_string(1 + std::count(text_.begin(), end, '\n'))});
  }

  std::string_view text_;
  const std::string& name_;
  std::string_view stop_at_;
  std::size_t at_ = 0;
  bool stopped_ = false;
};

}  // namespace

const std::string* XmlElement::attribute(std::string_view key) const {
  for (const auto& [name_of_it, value] : attributes) {
    if (name_of_it == key) return &value;
  }
  return nullptr;
}

const XmlElement* XmlElement::child(std::string_view key) const {
  for (const XmlElement& element : children) {
    if (element.name == key) return &element;
  }
  return nullptr;
}

XmlElement parse_xml(std::string_view text, const std::string& name, std::string_view stop_at) {
  return Parser(text, name, stop_at).parse();
}

std::string escape_xml(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto* const found = std::find_if(entities.begin(), entities.end(),
                                           [c](const auto& e) { return e.second == c; });
    if (found == entities.end()) {
      out += c;
    } else {
      out += found->first;
    }
  }
  return out;
}

}  // namespace kinemesh
