#include "reconstruct/anonymous.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

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
  change(mesh.provenance.command);
  change(mesh.provenance.options);
  change(mesh.provenance.source);
  for (Provenance::Input& input : mesh.provenance.inputs) change(input.path);
}

}  // namespace kinemesh
