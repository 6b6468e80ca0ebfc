// Leaving out who was recorded: the names of subjects, and of files, which often hold them.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reconstruct/convert.h"

namespace kinemesh {

/// Replaces names in texts, any case, the longest first. Names of three letters or fewer are
/// replaced only where they stand alone, so that a subject "A" does not change every word.
class Anonymiser {
 public:
  Anonymiser() = default;
  /// Knows the subjects of `session` (of markers, events and SUBJECTS:NAMES) as "subject1", ….
  explicit Anonymiser(const MarkerSequence& session);
  /// `replacement` for `name`; an empty name is ignored.
  void add(const std::string& name, const std::string& replacement);
  /// The path itself and the name of its file become `replacement` ("session.c3d").
  void add_path(const std::string& path, const std::string& replacement);
  std::string operator()(std::string text) const;
  /// A command line, word by word: the file of --config and every path that is left become names
  /// without meaning.
  std::string command(const std::string& line) const;

 private:
  std::vector<std::pair<std::string, std::string>> names_;  ///< longest first
};

/// Applies it to every text that is written about a conversion: labels, names, events, warnings,
/// provenance.
void anonymise(const Anonymiser& anonymiser, MarkerSequence& session, ConvertResult& result);

/// For a mesh that was read: who is meant is known from "SUBJECT:LABEL" names only, so the command,
/// the options and the source, where names may stand, too, are left out of its provenance.
void anonymise_mesh(AnimatedMesh& mesh);

}  // namespace kinemesh
