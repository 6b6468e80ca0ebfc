// The data arrays of VTK's XML files: as text, base64 or raw, compressed with zlib or not.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/formats/xml.h"

namespace kinemesh {

/// What a <VTKFile> says about all of its arrays.
struct VtkFile {
  std::string name;  ///< of the file, for errors
  bool big_endian = false;
  std::size_t header_bytes = 4;  ///< 4 (UInt32) or 8 (UInt64)
  bool compressed = false;
  std::string_view appended;  ///< behind the '_' of <AppendedData>; empty when there is none
  bool appended_base64 = false;
};

/// Reads the attributes of the root element. Throws InputError for compressors other than zlib.
VtkFile vtk_file_of(const XmlElement& root, const std::string& name);

/// All values of a numeric <DataArray> as double. Throws InputError naming the array.
std::vector<double> vtk_numbers(const VtkFile& file, const XmlElement& array);
/// As above for what is stored as Float32 mostly: no detour through double.
std::vector<float> vtk_floats(const VtkFile& file, const XmlElement& array);
/// The texts of an <Array type="String">.
std::vector<std::string> vtk_texts(const VtkFile& file, const XmlElement& array);

/// At most `max_bytes` bytes of base64 text, whose groups may end with padding anywhere; stops at
/// the first character that is not of base64 (blanks are skipped).
std::string decode_base64(std::string_view text, std::size_t max_bytes = std::string::npos);

}  // namespace kinemesh
