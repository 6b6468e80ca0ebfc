// Files that we write are read alike by ezc3d and by the Python package c3d, wherever these
// support the dialect. docs/c3d.md has the table of exceptions; each of them is a test here.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "capture/c3d/ezc3d_reader.h"
#include "capture/c3d/number_format.h"
#include "capture/c3d/writer.h"
#include "config/error.h"
#include "config/input_file.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/data.h"

namespace kinemesh::c3d_other_readers_test {
namespace {

/// A folder that is gone after the test.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "kinemesh_c3d_XXXXXX").string();
    EXPECT_NE(::mkdtemp(name.data()), nullptr);
    path_ = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

struct Dialect {
  std::string name;
  MarkerSequence take;
  C3dWriteOptions options;
};

/// Takes of every kind that a file can hold, in every processor and storage.
std::vector<Dialect> dialects() {
  std::vector<std::pair<std::string, MarkerSequence>> takes;
  takes.emplace_back("plain", test::make_take(40, 6));
  takes.emplace_back("analog", test::make_take(40, 6));
  test::add_analog(takes.back().second, 5, 10);
  takes.emplace_back("late", test::make_take(25, 3));
  takes.back().second.first_frame = 500;
  takes.emplace_back("utf8", test::make_take(10, 3));
  takes.back().second.markers()[0].label = "Großzehe";
  takes.back().second.markers()[1].subject = "Zoë";
  takes.emplace_back("events", test::make_take(200, 3));
  for (int e = 0; e < 30; ++e)
    takes.back().second.events.push_back({"smile " + std::to_string(e), "General", "", 0.0625 * e});
  takes.emplace_back("labels2", test::make_take(5, 300));
  takes.emplace_back("description", test::make_take(5, 2));
  takes.back().second.markers()[0].description = std::string(255, 'd');
  std::vector<Dialect> all;
  for (const auto& [name, take] : takes) {
    for (const char* processor : {"intel", "dec", "sgi"}) {
      for (const char* storage : {"int", "float"}) {
        all.push_back({name + "-" + processor + "-" + storage,
                       take,
                       {.processor = processor, .storage = storage}});
      }
    }
  }
  all.push_back({"metres", test::make_take(20, 4), {.storage = "float", .unit = "m"}});
  return all;
}

// ---- ezc3d --------------------------------------------------------------------------------------

void expect_ezc3d_reads_alike(const std::filesystem::path& path) {
  const C3dReadResult own = read_c3d(path);
  const C3dReadResult other = read_c3d(path, {.reader = C3dReader::ezc3d});
  for (std::size_t i = 0; i < own.take.sample_count(); ++i) {
    ASSERT_EQ(own.take.flags()[i], other.take.flags()[i]) << i;
    if (own.take.flags()[i] == 0) continue;
    for (std::size_t k = 0; k < 3; ++k)
      ASSERT_NEAR(own.take.positions()[3 * i + k], other.take.positions()[3 * i + k], 1e-3F) << i;
  }
  for (std::size_t i = 0; i < own.take.analog.values.size(); ++i)
    ASSERT_NEAR(own.take.analog.values[i], other.take.analog.values[i], 1e-3F) << i;
}

TEST(C3dOtherReaders, Ezc3dReadsWhatWeWrite) {
  const Folder folder;
  std::size_t compared = 0;
  for (const Dialect& d : dialects()) {
    SCOPED_TRACE(d.name);
    const auto path = folder / (d.name + ".c3d");
    write_c3d(d.take, path, d.options);
    if (d.options.processor == "sgi") {
      EXPECT_THROW(read_c3d(path, {.reader = C3dReader::ezc3d}),
                   InputError);  // not supported by it
      continue;
    }
    expect_ezc3d_reads_alike(path);
    ++compared;
  }
  EXPECT_EQ(compared, 29U);
}

TEST(C3dOtherReaders, Ezc3dKnowsNoLongFrames) {
  const Folder folder;
  write_c3d(test::make_take(70'000, 1), folder / "long.c3d");
  EXPECT_FALSE(ezc3d_refusal(read_c3d(folder / "long.c3d")).empty());
}

// ---- the Python package c3d ---------------------------------------------------------------------

struct PythonRead {
  uint32_t frames = 0, points = 0, channels = 0, samples = 0, first_frame = 0;
  double rate = 0.0;
  std::vector<double> values;  // per frame: points × 5, then channels × samples
  std::vector<std::string> labels;
};

std::filesystem::path python_package() {
  return std::filesystem::path(KINEMESH_DEPS_FOLDER) / "python_c3d";
}

/// Lets Python read all files at once: starting it takes longer than reading.
void run_python(const std::vector<std::filesystem::path>& paths) {
  const std::filesystem::path script =
      test::sample_folder().parent_path() / "tests/capture/read_with_python_c3d.py";
  std::string command =
      "/usr/bin/python3 '" + script.string() + "' '" + python_package().string() + "'";
  for (const auto& path : paths) command += " '" + path.string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
}

/// What run_python() found in a file.
PythonRead python_result(const std::filesystem::path& path) {
  PythonRead r;
  const std::string bytes = read_file(path.string() + ".bin");
  constexpr std::size_t head = 5 * 4 + 8;
  if (bytes.size() < head) return r;
  std::memcpy(&r.frames, bytes.data(), 20);
  std::memcpy(&r.rate, bytes.data() + 20, 8);
  r.values.resize(static_cast<std::size_t>(r.frames) * (5U * r.points + r.channels * r.samples));
  EXPECT_GE(bytes.size(), head + 8 * r.values.size());
  if (bytes.size() < head + 8 * r.values.size()) return r;
  std::memcpy(r.values.data(), bytes.data() + head, 8 * r.values.size());
  std::string label;
  for (const char c : bytes.substr(head + 8 * r.values.size()) + "\n") {
    if (c == '\n')
      r.labels.push_back(std::exchange(label, {}));
    else
      label += c;
  }
  return r;
}

void expect_same_points(const MarkerSequence& take, const PythonRead& python, double unit_mm) {
  const std::size_t row = 5U * python.points + python.channels * python.samples;
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      const double* p = python.values.data() + f * row + 5 * m;
      ASSERT_EQ(take.valid(f, m), p[3] >= 0.0) << f << " " << m;
      if (!take.valid(f, m)) continue;
      for (int k = 0; k < 3; ++k)
        ASSERT_NEAR(take.position(f, m)[k], p[k] * unit_mm, 1e-3) << f << " " << m;
      ASSERT_NEAR(take.residuals()[take.sample(f, m)], p[3] * unit_mm, 1e-3);
      ASSERT_EQ(static_cast<double>(take.camera_masks()[take.sample(f, m)]), p[4]);
    }
  }
}

void expect_same_analog(const AnalogData& analog, std::size_t frames, const PythonRead& python) {
  const std::size_t row = 5U * python.points + python.channels * python.samples;
  ASSERT_EQ(python.channels, analog.channels.size());
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t c = 0; c < python.channels; ++c) {
      for (std::size_t s = 0; s < python.samples; ++s) {
        const double theirs = python.values[f * row + 5U * python.points + c * python.samples + s];
        ASSERT_NEAR(analog.values[(f * python.samples + s) * python.channels + c], theirs, 1e-3);
      }
    }
  }
}

/// Skips without the package, or fails where data are required.
#define KINEMESH_NEED_PYTHON_C3D()                                                        \
  do {                                                                                    \
    if (!std::filesystem::exists(python_package() / "c3d")) {                             \
      if (std::getenv("KINEMESH_REQUIRE_DATA") != nullptr)                                \
        FAIL() << python_package() << " is missing";                                      \
      GTEST_SKIP() << "the Python package c3d is not installed; tools/setup installs it"; \
    }                                                                                     \
  } while (false)

TEST(C3dOtherReaders, ThePythonPackageReadsWhatWeWrite) {
  KINEMESH_NEED_PYTHON_C3D();
  const Folder folder;
  const std::vector<Dialect> all = dialects();
  std::vector<std::filesystem::path> paths;
  for (const Dialect& d : all) {
    paths.push_back(folder / (d.name + ".c3d"));
    write_c3d(d.take, paths.back(), d.options);
  }
  run_python(paths);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Dialect& d = all[i];
    const auto& path = paths[i];
    SCOPED_TRACE(d.name);
    const MarkerSequence take = read_c3d(path).take;
    const PythonRead python = python_result(path);
    ASSERT_EQ(python.frames, take.frame_count());
    ASSERT_EQ(python.points, take.marker_count());
    EXPECT_EQ(python.first_frame, take.first_frame);
    EXPECT_EQ(python.rate, take.rate_hz);
    expect_same_points(take, python, d.options.unit == "m" ? 1000.0 : 1.0);
    expect_same_analog(take.analog, take.frame_count(), python);
    // It ignores LABELS2.
    for (std::size_t m = 0; m < std::min<std::size_t>(take.marker_count(), 255); ++m) {
      const Marker& marker = take.markers()[m];
      EXPECT_EQ(python.labels.at(m),
                marker.subject.empty() ? marker.label : marker.subject + ":" + marker.label);
    }
  }
}

}  // namespace
}  // namespace kinemesh::c3d_other_readers_test
