#include "mesh/formats/npz.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "config/error.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "mesh/formats/zip.h"

namespace kinemesh::npz_test {
namespace {

std::filesystem::path temporary(const std::string& name) {
  return std::filesystem::temp_directory_path() /
         ("kinemesh-npz-" + std::to_string(::getpid()) + "-" + name);
}

TEST(Npz, ChecksumOfTheStandardExample) {
  EXPECT_EQ(crc32_of("123456789"), 0xCBF43926U);
  EXPECT_EQ(crc32_of(""), 0U);
}

TEST(Npz, EveryTypeComesBack) {
  const std::vector<float> f{1.5F, -2.0F, 3.25F, 0.0F, 5.0F, 6.0F};
  const std::vector<double> d{0.1, 0.2};
  const std::vector<int32_t> i{-7, 1 << 30};
  const std::vector<int64_t> l{int64_t{1} << 40};
  const std::vector<uint8_t> u{0, 200, 255};
  const std::vector<std::string> t{"LFHD", "", "Wange für Müller", "口"};
  NpzWriter writer;
  writer.add("f", {2, 3}, std::span(f));
  writer.add("d", {2}, std::span(d));
  writer.add("i", {2, 1}, std::span(i));
  writer.add("l", {1}, std::span(l));
  writer.add("u", {3}, std::span(u));
  writer.add_booleans("b", {3}, std::span(u));
  writer.add("t", std::span(t));
  writer.add("rate", 100.0);
  writer.add("unit", "mm");
  writer.add("none", {0, 3}, std::span<const float>());
  const auto path = temporary("types.npz");
  writer.write(path);
  const NpzFile file = read_npz(path);
  std::filesystem::remove(path);

  EXPECT_EQ(file.size(), 10U);
  EXPECT_EQ(npz_array(file, "f").shape, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(npz_array(file, "f").numbers(), std::vector<double>(f.begin(), f.end()));
  EXPECT_EQ(npz_array(file, "d").numbers(), d);
  EXPECT_EQ(npz_array(file, "i").numbers(), std::vector<double>(i.begin(), i.end()));
  EXPECT_EQ(npz_array(file, "l").numbers(), std::vector<double>{1099511627776.0});
  EXPECT_EQ(npz_array(file, "u").numbers(), (std::vector<double>{0, 200, 255}));
  EXPECT_EQ(npz_array(file, "b").numbers(), (std::vector<double>{0, 1, 1}));
  EXPECT_EQ(npz_array(file, "t").texts, t);
  EXPECT_TRUE(npz_array(file, "rate").shape.empty());
  EXPECT_EQ(npz_array(file, "rate").numbers(), std::vector<double>{100});
  EXPECT_EQ(npz_array(file, "unit").texts, std::vector<std::string>{"mm"});
  EXPECT_EQ(npz_array(file, "none").shape, (std::vector<std::size_t>{0, 3}));
  EXPECT_THROW(npz_array(file, "missing"), InputError);
  EXPECT_EQ(writer.bytes(), writer.bytes());
}

TEST(Npz, WrongShapeAndRepeatedNameAreBugs) {
  NpzWriter writer;
  const std::vector<float> f{1, 2, 3};
  EXPECT_THROW(writer.add("f", {2, 2}, std::span(f)), InternalError);
  writer.add("f", {3}, std::span(f));
  EXPECT_THROW(writer.add("f", {3}, std::span(f)), InternalError);
}

TEST(Npz, DamagedArchivesAreRefusedWhereverTheyAreCut) {
  NpzWriter writer;
  const std::vector<float> f{1, 2, 3};
  const std::vector<std::string> t{"a", "bc"};
  writer.add("f", {3}, std::span(f));
  writer.add("t", std::span(t));
  const std::string whole = writer.bytes();
  const auto path = temporary("cut.npz");
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    write_file(path, whole.substr(0, size));
    EXPECT_THROW(read_npz(path), InputError) << size;
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {  // a changed byte: an error or the arrays
    std::string mutant = whole;
    mutant[at] = static_cast<char>(mutant[at] ^ 0x41);
    write_file(path, mutant);
    try {
      read_npz(path);
    } catch (const InputError&) {
    }
  }
  std::filesystem::remove(path);
}

TEST(Npz, MembersThatShareDataAreRefused) {
  const std::string content(1000, 'x');
  const std::vector<ZipMember> members{{"a", content}};
  const std::string one = zip_of(members);
  EXPECT_EQ(zip_members(one, "f").size(), 1U);
  const std::size_t central = one.size() - 22 - 47;  // 46 bytes and the name "a"
  std::string many = one.substr(0, central);
  for (int i = 0; i < 3; ++i) many += one.substr(central, 47);
  std::string end = one.substr(central + 47);
  end[8] = end[10] = 3;
  end[12] = static_cast<char>(3 * 47);
  EXPECT_THROW(zip_members(many + end, "f"), InputError);
}

}  // namespace
}  // namespace kinemesh::npz_test
