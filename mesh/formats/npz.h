// NumPy archives (.npz): named arrays that Python reads with numpy.load. Written uncompressed; the
// same arrays give the same bytes. Format: the NPY and NPZ description of NumPy (NEP 1), in a ZIP
// archive (PKWARE APPNOTE 6.3) whose members are stored.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kinemesh {

/// Element types that an archive can hold.
enum class NpyType : uint8_t { float32, float64, int32, int64, uint8, boolean, text };

/// One array: C order (the last index varies fastest), little-endian.
struct NpyArray {
  NpyType type = NpyType::float64;
  std::vector<std::size_t> shape;  ///< empty for a single value
  std::string bytes;               ///< all types but text: the elements as they lie in memory
  std::vector<std::string> texts;  ///< text: UTF-8, one per element

  /// Product of the shape; 1 for a single value.
  std::size_t size() const;
  /// The elements converted to double. Throws InputError for text.
  std::vector<double> numbers() const;
};

/// Collects arrays and writes them as one archive.
class NpzWriter {
 public:
  /// Each copies its values; their number must be the product of the shape (else InternalError).
  /// A name is used once and is the key in Python: letters, digits and underscores.
  void add(std::string_view name, const std::vector<std::size_t>& shape,
           std::span<const float> values);
  void add(std::string_view name, const std::vector<std::size_t>& shape,
           std::span<const double> values);
  void add(std::string_view name, const std::vector<std::size_t>& shape,
           std::span<const int32_t> values);
  void add(std::string_view name, const std::vector<std::size_t>& shape,
           std::span<const int64_t> values);
  void add(std::string_view name, const std::vector<std::size_t>& shape,
           std::span<const uint8_t> values);
  /// True and false as NumPy's bool; every value other than 0 is true.
  void add_booleans(std::string_view name, const std::vector<std::size_t>& shape,
                    std::span<const uint8_t> values);
  /// A list of UTF-8 texts (NumPy's unicode strings).
  void add(std::string_view name, std::span<const std::string> texts);
  /// A single number or text (shape ()).
  void add(std::string_view name, double value);
  void add(std::string_view name, std::string_view text);

  /// Writes the file whole or not at all. Throws InputError when it cannot be written or would
  /// exceed 4 GiB.
  void write(const std::filesystem::path& path) const;
  /// The archive as it would be written.
  std::string bytes() const;

 private:
  void add_member(std::string_view name, std::string_view descr,
                  const std::vector<std::size_t>& shape, const void* data, std::size_t bytes);
  struct Member {
    std::string name;     // with .npy
    std::string content;  // a whole .npy file
  };
  std::vector<Member> members_;
};

/// The arrays of an archive by name, and single .npy files under the name "array".
using NpzFile = std::map<std::string, NpyArray, std::less<>>;

/// Reads what NpzWriter and numpy.savez write (uncompressed; float, integer, bool and text arrays
/// in C order, little-endian). Throws InputError naming file, array and reason for anything else.
NpzFile read_npz(const std::filesystem::path& path);

/// As above from the file's content; `name` is for errors.
NpzFile parse_npz(std::string_view content, const std::string& name);

/// The array of that name. Throws InputError naming it when it is missing.
const NpyArray& npz_array(const NpzFile& file, std::string_view name);

}  // namespace kinemesh
