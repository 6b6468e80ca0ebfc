#include <algorithm>
#include <charconv>
#include <cmath>

#include "config/error.h"
#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/faces.h"
#include "mesh/formats/metadata.h"
#include "mesh/formats/vtk_array.h"
#include "mesh/formats/vtp.h"

namespace kinemesh {
namespace {

const XmlElement* named(const XmlElement* parent, std::string_view name) {
  if (parent == nullptr) return nullptr;
  for (const XmlElement& child : parent->children) {
    const std::string* its = child.attribute("Name");
    if (its != nullptr && lower(*its) == name) return &child;
  }
  return nullptr;
}

class VtpReader {
 public:
  VtpReader(std::span<const std::byte> bytes, const std::string& name)
      : name_(name), root_(parse_xml(text_of(bytes), name, "AppendedData")) {}

  MeshData read() {
    file_ = vtk_file_of(root_, name_);
    const XmlElement* data = root_.child("PolyData");
    if (data == nullptr) fail(root_, "the file holds no PolyData");
    for (const XmlElement& piece : data->children) {
      if (piece.name == "Piece") read_piece(piece);
    }
    data_.allocate(1, positions_.size() / 3);
    std::copy(positions_.begin(), positions_.end(), data_.positions.begin());
    if (filled_.size() == data_.vertex_count && !filled_.empty()) {
      data_.filled = Buffer<uint8_t>(filled_.size());
      std::copy(filled_.begin(), filled_.end(), data_.filled.begin());
    }
    if (uncertainty_.size() == data_.vertex_count && !uncertainty_.empty()) {
      data_.uncertainty = Buffer<float>(uncertainty_.size());
      std::copy(uncertainty_.begin(), uncertainty_.end(), data_.uncertainty.begin());
    }
    if (names_.size() == data_.vertex_count) data_.vertex_names = std::move(names_);
    faces_.finish(data_);
    read_description(data->child("FieldData"));
    return std::move(data_);
  }

 private:
  [[noreturn]] void fail(const XmlElement& at, const std::string& what) const {
    throw InputError(
        {.what = what, .file = name_, .place = "byte " + std::to_string(at.text_begin)});
  }

  void read_piece(const XmlElement& piece) {
    const XmlElement* points = piece.child("Points");
    const XmlElement* array = points != nullptr ? points->child("DataArray") : nullptr;
    const std::size_t first = positions_.size() / 3;
    if (array != nullptr) {
      const std::string* components = array->attribute("NumberOfComponents");
      if (components != nullptr && *components != "3")
        fail(*array, "points do not have three components");
      const std::vector<float> values = vtk_floats(file_, *array);
      if (values.size() % 3 != 0) fail(*array, "the number of coordinates is no multiple of three");
      positions_.insert(positions_.end(), values.begin(), values.end());
    }
    count_ = positions_.size() / 3 - first;
    read_cells(piece.child("Polys"), first, false);
    read_cells(piece.child("Strips"), first, true);
    const XmlElement* point_data = piece.child("PointData");
    if (const XmlElement* filled = named(point_data, "filled")) {
      for (const double f : vtk_numbers(file_, *filled)) filled_.push_back(f != 0 ? 1 : 0);
    }
    if (const XmlElement* deviation = named(point_data, "uncertainty")) {
      const std::vector<float> values = vtk_floats(file_, *deviation);
      uncertainty_.insert(uncertainty_.end(), values.begin(), values.end());
    }
    if (const XmlElement* names = named(point_data, "vertex_name")) {
      for (std::string& text : vtk_texts(file_, *names)) names_.push_back(std::move(text));
    }
  }

  void read_cells(const XmlElement* cells, std::size_t first, bool strips) {
    const XmlElement* connectivity = named(cells, "connectivity");
    const XmlElement* offsets = named(cells, "offsets");
    if (connectivity == nullptr || offsets == nullptr) return;
    const std::vector<double> corners = vtk_numbers(file_, *connectivity);
    std::size_t begin = 0;
    for (const double offset : vtk_numbers(file_, *offsets)) {
      if (!(offset >= static_cast<double>(begin) &&
            offset <= static_cast<double>(corners.size()))) {
        fail(*offsets, "cell " + std::to_string(cell_) + " ends at corner " +
                           format_number(offset) + " of " + std::to_string(corners.size()));
      }
      const auto end = static_cast<std::size_t>(offset);
      polygon_.clear();
      for (std::size_t i = begin; i < end; ++i)
        polygon_.push_back(vertex(*connectivity, corners[i], first));
      if (strips) {
        add_strip();
      } else {
        faces_.add(polygon_);
      }
      begin = end;
      ++cell_;
    }
  }

  VertexIndex vertex(const XmlElement& at, double index, std::size_t first) const {
    if (!(index >= 0 && index < static_cast<double>(count_)) || index != std::floor(index)) {
      fail(at, "cell " + std::to_string(cell_) + " refers to point " + format_number(index) +
                   " (0-based), but there are only " + std::to_string(count_));
    }
    return static_cast<VertexIndex>(first + static_cast<std::size_t>(index));
  }

  void add_strip() {
    for (std::size_t i = 2; i < polygon_.size(); ++i) {
      Triangle t{polygon_[i - 2], polygon_[i - 1], polygon_[i]};
      if (i % 2 != 0) std::swap(t[0], t[1]);
      faces_.add(t);
    }
  }

  void read_description(const XmlElement* field_data) {
    const XmlElement* lines = named(field_data, "kinemesh");
    if (lines == nullptr) return;
    MetadataReader metadata;
    for (const std::string& line : vtk_texts(file_, *lines)) metadata.read(line);
    metadata.apply(data_);
  }

  const std::string& name_;
  XmlElement root_;
  VtkFile file_;
  MeshData data_;
  std::vector<float> positions_, uncertainty_;
  std::vector<uint8_t> filled_;
  std::vector<std::string> names_;
  FaceCollector faces_;
  std::vector<VertexIndex> polygon_;
  std::size_t count_ = 0, cell_ = 0;
};

}  // namespace

MeshData decode_vtp(std::span<const std::byte> bytes, const std::string& name) {
  return VtpReader(bytes, name).read();
}

std::vector<PvdEntry> decode_pvd(std::span<const std::byte> bytes, const std::string& name) {
  const XmlElement root = parse_xml(text_of(bytes), name);
  const XmlElement* collection = root.child("Collection");
  if (root.name != "VTKFile" || collection == nullptr) {
    throw InputError({.what = "this is no PVD file: it holds no <Collection>", .file = name});
  }
  std::vector<PvdEntry> entries;
  for (const XmlElement& set : collection->children) {
    if (set.name != "DataSet") continue;
    const std::string place = "entry " + std::to_string(entries.size() + 1);
    const std::string* part = set.attribute("part");
    if (part != nullptr && *part != "0" && !part->empty()) {
      throw InputError({.what = "a collection of several parts is not read",
                        .file = name,
                        .place = place,
                        .remedy = "Merge the parts first"});
    }
    const std::string* file = set.attribute("file");
    if (file == nullptr || file->empty()) {
      throw InputError({.what = "the entry names no file", .file = name, .place = place});
    }
    PvdEntry entry{static_cast<double>(entries.size()), *file};
    if (const std::string* time = set.attribute("timestep")) {
      const char* const end = time->data() + time->size();
      if (std::from_chars(time->data(), end, entry.timestep).ec != std::errc() ||
          !std::isfinite(entry.timestep)) {
        throw InputError({.what = "the timestep '" + time->substr(0, 40) + "' is no number",
                          .file = name,
                          .place = place});
      }
    }
    entries.push_back(std::move(entry));
  }
  if (entries.empty()) throw InputError({.what = "the collection is empty", .file = name});
  std::stable_sort(entries.begin(), entries.end(),
                   [](const PvdEntry& a, const PvdEntry& b) { return a.timestep < b.timestep; });
  return entries;
}

}  // namespace kinemesh
