#include "reconstruct/anonymous.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "config/shell_words.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::size_t longest_whole_word = 3;

bool is_letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

/// Whether text[at, at + length) is no part of a longer word.
bool stands_alone(const std::string& text, std::size_t at, std::size_t length) {
  return (at == 0 || !is_letter(text[at - 1])) &&
         (at + length == text.size() || !is_letter(text[at + length]));
}

/// "file.c3d" for a path of which nothing is known.
std::string path_without_name(const std::string& path) {
  return "file" + std::filesystem::path(path).extension().string();
}

}  // namespace

Anonymiser::Anonymiser(const MarkerSequence& session) {
  std::vector<std::string> subjects;
  const auto note = [&subjects](std::string_view name) {
    const std::string word(trim(name));
    if (!word.empty() && std::ranges::find(subjects, word) == subjects.end()) {
      subjects.push_back(word);
    }
  };
  for (const Marker& marker : session.markers()) note(marker.subject);
  for (const Event& event : session.events) note(event.subject);
  if (const C3dParameter* names = session.parameters.find("SUBJECTS", "NAMES")) {
    for (const std::string& name : names->strings()) note(name);
  }
  for (std::size_t i = 0; i < subjects.size(); ++i) {
    add(subjects[i], "subject" + std::to_string(i + 1));
  }
}

void Anonymiser::add(const std::string& name, const std::string& replacement) {
  if (name.empty()) return;
  names_.emplace_back(lower(name), replacement);
  std::ranges::stable_sort(names_, std::greater{}, [](const auto& n) { return n.first.size(); });
}

void Anonymiser::add_path(const std::string& path, const std::string& replacement) {
  if (path.empty()) return;
  const std::filesystem::path file(path);
  add(path, replacement);
  add(file.filename().string(), replacement);
  add(file.stem().string(), std::filesystem::path(replacement).stem().string());
}

std::string Anonymiser::operator()(std::string text) const {
  const std::string folded = lower(text);
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const auto fits = [&](const auto& entry) {
      const std::string& name = entry.first;
      return folded.compare(at, name.size(), name) == 0 &&
             (name.size() > longest_whole_word || stands_alone(folded, at, name.size()));
    };
    const auto found = std::ranges::find_if(names_, fits);
    if (found == names_.end()) {
      out += text[at++];
    } else {
      out += found->second;
      at += found->first.size();
    }
  }
  return out;
}

std::string Anonymiser::command(const std::string& line) const {
  std::string out;
  bool config = false;
  for (const std::string& word : shell_words(line)) {
    const std::size_t equals = word.starts_with("--") ? word.find('=') : std::string::npos;
    const std::string option = equals == std::string::npos ? "" : word.substr(0, equals + 1);
    const std::string value = word.substr(option.size());
    std::string shown = config || option == "--config=" ? "options.toml" : (*this)(value);
    if (shown.find('/') != std::string::npos) shown = path_without_name(shown);
    config = word == "--config";
    out += (out.empty() ? "" : " ") + shell_quote(option + shown);
  }
  return out;
}

void anonymise(const Anonymiser& anonymiser, MarkerSequence& session, ConvertResult& result) {
  const auto change = [&anonymiser](std::string& text) { text = anonymiser(std::move(text)); };
  const auto change_marker = [&](Marker& marker) {
    change(marker.label);
    change(marker.subject);
    change(marker.description);
  };
  const auto change_event = [&](Event& event) {
    change(event.label);
    change(event.subject);
  };
  std::ranges::for_each(session.markers(), change_marker);
  std::ranges::for_each(session.events, change_event);
  change(session.origin.path);
  change(session.origin.manufacturer);
  std::ranges::for_each(result.markers, change_marker);
  std::ranges::for_each(result.rigid, change);
  std::ranges::for_each(result.warnings, change);
  for (MarkerDecision& decision : result.selection.decisions) change(decision.text);
  for (OpeningCandidate& candidate : result.triangulation.candidates) change(candidate.reason);
  AnimatedMesh& mesh = result.animation;
  std::ranges::for_each(mesh.vertex_names, change);
  std::ranges::for_each(mesh.events, change_event);
  mesh.provenance.command = anonymiser.command(mesh.provenance.command);
  change(mesh.provenance.options);
  change(mesh.provenance.source);
  for (Provenance::Input& input : mesh.provenance.inputs) change(input.path);
}

void anonymise_mesh(AnimatedMesh& mesh) {
  std::vector<Marker> known;
  const auto note = [&known](const std::string& text, const std::string& subject) {
    const std::size_t colon = text.find(':');
    if (!subject.empty()) known.push_back({.label = text, .subject = subject});
    if (colon != std::string::npos && colon > 0) {
      known.push_back({.label = text, .subject = text.substr(0, colon)});
    }
  };
  for (const std::string& name : mesh.vertex_names) note(name, "");
  for (const Event& event : mesh.events) note(event.label, event.subject);
  const Anonymiser anonymiser(MarkerSequence::invalid(0, known, 1.0));
  for (std::string& name : mesh.vertex_names) name = anonymiser(name);
  for (Event& event : mesh.events) {
    event.label = anonymiser(event.label);
    event.subject = anonymiser(event.subject);
  }
  mesh.provenance.command.clear();
  mesh.provenance.options.clear();
  mesh.provenance.source.clear();
  for (std::size_t i = 0; i < mesh.provenance.inputs.size(); ++i) {
    std::string& path = mesh.provenance.inputs[i].path;
    path = "input" + std::to_string(i + 1) + std::filesystem::path(path).extension().string();
  }
}

}  // namespace kinemesh
