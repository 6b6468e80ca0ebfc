#include "tests/fuzz/session_targets.h"

#include <algorithm>
#include <stdexcept>

#include "capture/c3d/lint.h"
#include "capture/c3d/repair.h"
#include "capture/c3d/summary.h"
#include "capture/formats/motive_csv.h"
#include "capture/formats/qtm_tsv.h"
#include "capture/formats/session_csv.h"
#include "capture/formats/trc.h"

namespace kinemesh::fuzz {
namespace {

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Whatever was read can be linted, summed up and repaired, and the repaired file is sound.
Outcome check_and_repair(std::span<const std::byte> bytes) {
  C3dRepairResult repair;
  const std::string repaired = repaired_bytes(text_of(bytes), "mutant.c3d", {}, repair);
  const C3dReadResult read = read_c3d(std::as_bytes(std::span(repaired)), "repaired.c3d");
  lint_session(read.take, &read.layout);
  summary_text(summarise(read.take, &read.layout));
  if (has_errors(read.findings)) {
    const auto it = std::ranges::find(read.findings, Severity::error, &C3dFinding::severity);
    throw std::logic_error("the repaired file has " + it->code + ": " + it->place + ": " +
                           it->message);
  }
  if (repair.data_verbatim && repair.changed != 0) {
    throw std::logic_error("the repair changed " + std::to_string(repair.changed) + " values");
  }
  return repair.before.empty() ? Outcome::read : Outcome::read_with_findings;
}

/// Whatever was read can be linted and summed up.
template <MarkerSequence (*Read)(const TableText&, const TableReadOptions&, const RunContext&)>
Outcome read_table(std::span<const std::byte> bytes) {
  const MarkerSequence take = Read({std::string(text_of(bytes)), "mutant.csv"}, {}, {});
  lint_session(take, nullptr);
  summary_text(summarise(take, nullptr, "table"));
  return Outcome::read;
}

/// A table of each kind, by the name of its target.
std::vector<Seed> table_seeds() {
  return {
      {.name = "csv",
       .bytes = "# kinemesh points csv 1\n# rate_hz,100\n# event,Smile,General,A,0.02\n"
                "# marker,K,,K,angle,deg\n"
                "frame,time_s,A:L.x,A:L.y,A:L.z,A:L.valid,A:L.residual,K.x,K.y,K.z\n"
                "3,0.02,1.5,2,3,1,0.5,4,5,6\n4,0.03,,,,0,,4,5,6\n6,0.05,1,2,3,2,0,,,\n"},
      {.name = "trc",
       .bytes =
           "PathFileType\t4\t(X/Y/Z)\ta.trc\n"
           "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
           "OrigNumFrames\n60\t60\t2\t2\tm\t60\t1\t2\nFrame#\tTime\tA\t\t\tB\n"
           "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n1\t0\t1\t2\t3\t4\t5\t6\n2\t0.016667\t1\t2\t3\t\t\t\n"},
      {.name = "motive-csv",
       .bytes = "Format Version,1.23,Take Name,T,Export Frame Rate,120,Length Units,Meters\n\n"
                ",Type,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker\n"
                ",Name,H,H,H,H:M1,H:M1,H:M1\n,ID,a,a,a,b,b,b\n"
                ",,Position,Position,Position,Position,Position,Position\n"
                "Frame,Time (Seconds),X,Y,Z,X,Y,Z\n0,0,1,2,3,4,5,6\n1,0.00833,1,2,3,,,\n"},
      {.name = "qtm-tsv",
       .bytes = "NO_OF_FRAMES\t2\nNO_OF_MARKERS\t2\nFREQUENCY\t100\nDATA_INCLUDED\t3D\n"
                "EVENT\tSmile\t2\t0.01\nMARKER_NAMES\ta\tb\nTRAJECTORY_TYPES\tMeasured\tVirtual\n"
                "1\t0\t1\t2\t3\t4\t5\t6\n2\t0.01\t0\t0\t0\t4\t5\t6\n"},
  };
}

Target table_target(const std::string& name, const std::vector<std::string>& extensions,
                    Outcome (*run)(std::span<const std::byte>)) {
  return {.name = name,
          .extensions = extensions,
          .run = run,
          .own_seeds =
              [name] {
                std::vector<Seed> seeds = table_seeds();
                std::erase_if(seeds, [&](const Seed& seed) { return seed.name != name; });
                return seeds;
              },
          .payload = {},
          .max_seed_bytes = std::size_t{1} << 17};
}

}  // namespace

std::vector<Target> session_targets(const std::function<std::vector<Seed>()>& c3d_seeds) {
  return {
      {.name = "c3d-repair",
       .extensions = {".c3d"},
       .run = check_and_repair,
       .own_seeds = c3d_seeds,
       .payload = {},
       .max_seed_bytes = std::size_t{1} << 19},
      table_target("csv", {".csv"}, read_table<read_session_csv>),
      table_target("trc", {".trc"}, read_table<read_trc>),
      table_target("motive-csv", {".csv"}, read_table<read_motive_csv>),
      table_target("qtm-tsv", {".tsv"}, read_table<read_qtm>),
  };
}

}  // namespace kinemesh::fuzz
