// The list of sessions that one batch converts with one set of options.
//
//   # study.toml                                # study.csv
//   output = "results"                          session,output,topology
//   extension = ".glb"                          a/happy.c3d,happy.ply,
//   [options.gaps]                              a/surprise.c3d,surprise.ply,happy.ply
//   max-gap = 0.1
//   [[session]]
//   session = "a/happy.c3d"
//   [[session]]
//   session = "a/surprise.c3d"
//   output = "surprise.glb"
//   topology = "happy.glb"
//
// Paths of sessions are relative to the manifest, those of outputs to the output folder. A topology
// is the output of another session of the list, which is then converted first, or else a file
// relative to the manifest.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kinemesh {

struct BatchSession {
  std::filesystem::path session;
  std::filesystem::path output;
  std::filesystem::path topology;    ///< empty: the session gets a triangulation of its own
  std::optional<std::size_t> after;  ///< index of the session whose output `topology` is
  std::size_t line = 0;              ///< of the manifest
};

struct BatchManifest {
  std::filesystem::path file;
  std::filesystem::path folder;  ///< where outputs go
  std::string options_toml;      ///< the table [options] as a document, on the same lines as in the
                                 ///< file where possible; empty when there is none
  std::vector<BatchSession> sessions;
};

struct BatchManifestOptions {
  std::string folder{};            ///< instead of the manifest's own `output`
  std::string extension = ".ply";  ///< of outputs that are not named
};

/// Throws InputError naming file, line and remedy for a manifest that cannot be read, names no
/// session, gives two sessions the same output, writes over a session or topology, or lets sessions
/// wait for each other in a circle. Whether the sessions exist is not looked at.
BatchManifest read_batch_manifest(const std::filesystem::path& file,
                                  const BatchManifestOptions& options = {});

}  // namespace kinemesh
