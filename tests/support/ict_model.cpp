#include "tests/support/ict_model.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "config/error.h"
#include "config/input_file.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "tests/support/data.h"

namespace kinemesh::test {

namespace {

constexpr float mm_per_cm = 10;

std::vector<std::vector<Eigen::Vector3f>> read_deltas(const std::filesystem::path& path,
                                                      std::size_t count, std::size_t vertices) {
  const std::string bytes = read_file(path);
  const std::size_t shape_bytes = vertices * sizeof(Eigen::Vector3f);
  if (bytes.size() != count * shape_bytes) {
    throw InputError({.what = "The file must hold " + count_of(count, "shape") + " of " +
                              count_of(vertices, "vertex", "vertices"),
                      .file = path.string()});
  }
  std::vector<std::vector<Eigen::Vector3f>> shapes(count, std::vector<Eigen::Vector3f>(vertices));
  for (std::size_t k = 0; k < count; ++k) {
    std::memcpy(static_cast<void*>(shapes[k].data()), bytes.data() + k * shape_bytes, shape_bytes);
    for (Eigen::Vector3f& d : shapes[k]) d *= mm_per_cm;
  }
  return shapes;
}

}  // namespace

std::size_t IctModel::expression(std::string_view name) const {
  const auto found = std::find(expression_names.begin(), expression_names.end(), name);
  if (found == expression_names.end()) {
    throw UsageError({.what = "The face model has no expression named " + std::string(name),
                      .remedy = "Did you mean " + nearest_word(name, expression_names) + "?"});
  }
  return static_cast<std::size_t>(found - expression_names.begin());
}

std::shared_ptr<const IctModel> load_ict(const std::filesystem::path& folder) {
  const auto meta = nlohmann::json::parse(read_file(folder / "meta.json"));
  const Mesh neutral = read_mesh(builtin_mesh_formats(), folder / "neutral.ply");
  auto model = std::make_shared<IctModel>();
  model->topology = neutral.topology;
  for (const Eigen::Vector3f& p : neutral.positions) {
    model->neutral.emplace_back(p.cast<double>() * mm_per_cm);
  }
  const std::size_t vertices = neutral.positions.size();
  model->expression_names = meta.at("expression").get<std::vector<std::string>>();
  model->identities =
      read_deltas(folder / "identity_deltas.f32", meta.at("identity").size(), vertices);
  model->expressions =
      read_deltas(folder / "expression_deltas.f32", model->expression_names.size(), vertices);
  model->landmarks = meta.at("landmarks").get<std::vector<VertexIndex>>();
  model->rigid = meta.at("rigid").get<std::vector<VertexIndex>>();
  for (const auto* list : {&model->landmarks, &model->rigid}) {
    if (std::any_of(list->begin(), list->end(), [&](VertexIndex v) { return v >= vertices; })) {
      throw InputError(
          {.what = "A landmark is no vertex", .file = (folder / "meta.json").string()});
    }
  }
  return model;
}

const IctModel& ict_model() {
  static const std::shared_ptr<const IctModel> model = load_ict(data_folder() / "face_ict");
  return *model;
}

}  // namespace kinemesh::test
