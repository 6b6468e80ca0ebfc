// What is no readable C3D file is refused with a reason, and never hangs.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "capture/c3d/writer.h"
#include "config/error.h"
#include "tests/support/c3d_takes.h"

namespace kinemesh::c3d_bad_paths_test {
namespace {

std::string refusal(const std::filesystem::path& path) {
  try {
    read_c3d(path);
  } catch (const InputError& e) {
    EXPECT_EQ(e.details().file, path.string());
    return e.details().what;
  }
  ADD_FAILURE() << path << " was read";
  return {};
}

class C3dBadPaths : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "kinemesh_bad_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::filesystem::path file(const std::string& bytes) const {
    std::ofstream(folder_ / "a.c3d", std::ios::binary) << bytes;
    return folder_ / "a.c3d";
  }
  std::filesystem::path folder_;
};

TEST_F(C3dBadPaths, OnlyRegularFilesAreRead) {
  ASSERT_EQ(::mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  EXPECT_NE(refusal(folder_).find("a folder"), std::string::npos);
  EXPECT_NE(refusal(folder_ / "fifo").find("a named pipe"), std::string::npos);
  EXPECT_NE(refusal("/dev/null").find("a device"), std::string::npos);
  EXPECT_NE(refusal(folder_ / "missing.c3d").find("No such file"), std::string::npos);
}

TEST_F(C3dBadPaths, UnreadableFilesAreRefused) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may read every file";
  const auto path = file("x");
  std::filesystem::permissions(path, std::filesystem::perms::none);
  EXPECT_NE(refusal(path).find("Permission denied"), std::string::npos);
}

TEST_F(C3dBadPaths, EmptyShortAndForeignFilesAreRefused) {
  EXPECT_EQ(refusal(file("")), "the file is empty");
  EXPECT_NE(refusal(file("short")).find("5 bytes"), std::string::npos);
  EXPECT_NE(refusal(file(std::string(5000, 'x'))).find("no C3D file"), std::string::npos);
  EXPECT_NE(refusal(file(std::string(5000, '\0'))).find("no C3D file"), std::string::npos);
}

TEST_F(C3dBadPaths, ClaimsOfTheFileCostNoMemory) {
  // A header that claims 65,535 points, samples and frames, and no data.
  std::string bytes(2048, '\0');
  bytes[0] = 2;
  bytes[1] = 80;
  for (const std::size_t at : {2U, 4U, 8U, 18U}) bytes[at] = bytes[at + 1] = '\xFF';
  EXPECT_THROW(read_c3d(file(bytes)), InputError);
}

// A file that shrinks while it is read gives a clear error or its complete frames, never a signal.
TEST_F(C3dBadPaths, AFileMayShrinkWhileItIsRead) {
  const std::string bytes = encode_c3d(test::make_take(20'000, 10));
  const auto path = file(bytes);
  std::atomic<bool> stop{false};
  std::thread shrinker([&] {
    while (!stop) {
      std::filesystem::resize_file(path, 10'000);
      std::filesystem::resize_file(path, bytes.size());
    }
  });
  for (int i = 0; i < 50; ++i) {
    try {
      read_c3d(path);
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("shrank"), std::string::npos) << e.what();
    }
  }
  stop = true;
  shrinker.join();
}

}  // namespace
}  // namespace kinemesh::c3d_bad_paths_test
