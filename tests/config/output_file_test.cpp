#include "config/output_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>

#include "config/error.h"
#include "config/input_file.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::output_file_test {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

TEST(OutputFile, AppearsOnlyOnCommit) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.txt";
  {
    OutputFile file(path);
    file.write("half");
    EXPECT_FALSE(fs::exists(path));
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
  OutputFile file(path);
  file.write("12345678");
  file.seek(2);
  file.write("xy");
  file.commit();
  EXPECT_EQ(read_file(path), "12xy5678");
  EXPECT_EQ(folder.entry_count(), 1U);
}

TEST(OutputFile, AnEarlierFileSurvivesAFailedWrite) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.txt";
  write_file(path, "before");
  { OutputFile(path).write("after"); }
  EXPECT_EQ(read_file(path), "before");
}

TEST(OutputFile, AFullDiskIsNamedAndLeavesNothing) {
  const TemporaryFolder folder;
  // A limit on the file size stands in for a full disk: both make the write fail half-way.
  std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit before {};
  getrlimit(RLIMIT_FSIZE, &before);
  const struct rlimit small { 4096, before.rlim_max };
  setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_THROW(write_file(folder.path() / "a.bin", std::string(1U << 20U, 'x')), InputError);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_DFL);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(OutputFile, MissingFoldersAreMadeAndGoWithAFileThatIsNotFinished) {
  const TemporaryFolder folder;
  { const OutputFile unfinished(folder.path() / "new" / "deep" / "a.txt"); }
  EXPECT_TRUE(fs::is_empty(folder.path()));
  write_file(folder.path() / "new" / "deep" / "a.txt", "1");
  EXPECT_EQ(read_file(folder.path() / "new" / "deep" / "a.txt"), "1");
}

TEST(OutputFile, FilesAsFoldersAndFoldersAsFilesAreRefused) {
  const TemporaryFolder folder;
  write_file(folder.path() / "file", "1");
  try {
    OutputFile file(folder.path() / "file" / "a.txt");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("file: cannot create the folder"), std::string::npos)
        << e.what();
  }
  EXPECT_EQ(read_file(folder.path() / "file"), "1");
  EXPECT_THROW(OutputFile file(folder.path()), InputError);
  EXPECT_THROW(OutputFile file("/dev/null"), InputError);
}

TEST(OutputSet, FilesAppearTogetherOrNotAtAll) {
  const TemporaryFolder folder;
  {
    OutputSet set;
    set.create_folder(folder.path() / "new" / "deep");
    set.add(folder.path() / "new" / "deep" / "a", "1");
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
  OutputSet set;
  set.create_folder(folder.path() / "new");
  set.add(folder.path() / "new" / "a", "1");
  set.add(folder.path() / "b", "2");
  EXPECT_TRUE(fs::is_empty(folder.path() / "new") == false);
  EXPECT_FALSE(fs::exists(folder.path() / "b"));
  set.commit();
  EXPECT_EQ(read_file(folder.path() / "new" / "a"), "1");
  EXPECT_EQ(read_file(folder.path() / "b"), "2");
}

TEST(InputFile, OnlyRegularFilesAreRead) {
  const TemporaryFolder folder;
  EXPECT_THROW(read_file(folder.path()), InputError);
  EXPECT_THROW(read_file("/dev/null"), InputError);
  EXPECT_THROW(read_file(folder.path() / "missing"), InputError);
  const fs::path fifo = folder.path() / "fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THROW(read_file(fifo), InputError);  // and does not hang
  write_file(folder.path() / "big", "123456");
  EXPECT_THROW(read_file(folder.path() / "big", 5), InputError);
}

TEST(InputFile, AFileThatShrinksGivesAShortRead) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a";
  write_file(path, std::string(1000, 'x'));
  const InputFile file(path);
  fs::resize_file(path, 10);
  std::string buffer(1000, '\0');
  EXPECT_EQ(file.read_at(0, buffer.data(), buffer.size()), 10U);
}

TEST(Sha256, AgreesWithThePublishedExamples) {
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  const TemporaryFolder folder;
  write_file(folder.path() / "a", std::string(1000000, 'a'));
  EXPECT_EQ(sha256_of_file(folder.path() / "a"),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace kinemesh::output_file_test
