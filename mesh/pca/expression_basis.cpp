#include "mesh/pca/expression_basis.h"

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"
#include "mesh/formats/npz.h"

namespace kinemesh {
namespace {

using Eigen::Index;

void check_same(const Topology& basis, const AnimatedMesh& animation) {
  if (animation.vertex_count() == basis.vertex_count() && animation.topology() == basis) return;
  throw InputError({.what = "the animations differ in their meshes: " +
                            count_of(basis.vertex_count(), "vertex", "vertices") + " and " +
                            count_of(animation.vertex_count(), "vertex", "vertices"),
                    .remedy = "A basis describes animations of one mesh: move the others onto it "
                              "with kinemesh retarget"});
}

[[noreturn]] void malformed(const std::filesystem::path& path, const std::string& what) {
  throw InputError(
      {.what = what, .file = path.string(), .remedy = "Write the basis again with kinemesh basis"});
}

std::vector<double> numbers_of(const std::filesystem::path& path, const NpzFile& file,
                               const char* name, const std::vector<std::size_t>& shape) {
  const NpyArray& array = npz_array(file, name);
  if (array.shape != shape)
    malformed(path, std::string("the array '") + name + "' has the wrong shape");
  std::vector<double> values = array.numbers();
  if (!std::ranges::all_of(values, [](double v) { return std::isfinite(v); })) {
    malformed(path, std::string("the array '") + name + "' holds a value that is not finite");
  }
  return values;
}

}  // namespace

ExpressionBasis make_expression_basis(const std::vector<AnimatedMesh>& animations,
                                      const PcaOptions& options, const RunContext& ctx) {
  if (animations.empty() || animations.front().vertex_count() == 0) {
    throw InputError({.what = "a basis needs an animation", .remedy = "Give one or several"});
  }
  ExpressionBasis basis;
  basis.topology = animations.front().shared_topology();
  std::size_t frames = 0;
  for (const AnimatedMesh& animation : animations) {
    check_same(*basis.topology, animation);
    basis.frame_counts.push_back(animation.frame_count());
    frames += animation.frame_count();
  }
  if (animations.size() == 1) {
    basis.pca = pca_of(animations.front(), options, ctx);
    return basis;
  }
  AnimatedMesh all(basis.topology, frames, animations.front().rate_hz);
  auto to = all.positions().begin();
  for (const AnimatedMesh& animation : animations) {
    to = std::ranges::copy(animation.positions(), to).out;
  }
  basis.pca = pca_of(all, options, ctx);
  return basis;
}

ExpressionScores express(const ExpressionBasis& basis, const AnimatedMesh& animation,
                         const RunContext& ctx) {
  check_same(*basis.topology, animation);
  const auto frames = static_cast<Index>(animation.frame_count());
  const auto modes = static_cast<Index>(basis.pca.mode_count());
  const auto vertices = static_cast<double>(basis.topology->vertex_count());
  ExpressionScores result{Eigen::MatrixXd(frames, modes), Eigen::VectorXd(frames), 0.0};
  Eigen::VectorXd motion(frames);
  parallel_for(ctx, animation.frame_count(), 4, [&](std::size_t f) {
    const auto row = static_cast<Index>(f);
    const Eigen::Map<const Eigen::VectorXf> x(
        animation.positions().data() + f * 3 * basis.topology->vertex_count(),
        basis.pca.mean.size());
    const Eigen::VectorXf off = x - basis.pca.mean;
    const Eigen::VectorXf scores = basis.pca.modes.transpose() * off;
    const Eigen::VectorXf left = off - basis.pca.modes * scores;
    result.scores.row(row) = scores.cast<double>().transpose();
    result.rms_error_mm[row] = std::sqrt(left.cast<double>().squaredNorm() / vertices);
    motion[row] = off.cast<double>().squaredNorm() / vertices;
  });
  const double total = motion.sum();
  result.explained =
      total > 0.0 ? std::max(0.0, 1.0 - result.rms_error_mm.squaredNorm() / total) : 1.0;
  return result;
}

AnimatedMesh animation_from(const ExpressionBasis& basis, const Eigen::MatrixXd& scores,
                            double rate_hz) {
  AnimatedMesh mesh(basis.topology, static_cast<std::size_t>(scores.rows()), rate_hz);
  for (Index f = 0; f < scores.rows(); ++f) {
    const std::vector<double> row(scores.row(f).begin(), scores.row(f).end());
    const Eigen::VectorXf frame = reconstruct(basis.pca, row);
    std::copy(frame.begin(), frame.end(), mesh.positions().begin() + f * frame.size());
  }
  return mesh;
}

void write_expression_basis(const std::filesystem::path& path, const ExpressionBasis& basis) {
  const PcaResult& pca = basis.pca;
  const std::size_t vertices = pca.vertex_count, modes = pca.mode_count();
  const auto frames = static_cast<std::size_t>(pca.scores.rows());
  NpzWriter npz;
  npz.add("mean", {vertices, 3}, std::span<const float>(pca.mean.data(), 3 * vertices));
  npz.add("modes", {modes, vertices, 3},
          std::span<const float>(pca.modes.data(), 3 * vertices * modes));
  npz.add("variances", {modes}, std::span<const double>(pca.variances.data(), modes));
  std::vector<double> explained, errors, scores;
  for (std::size_t k = 1; k <= modes; ++k) {
    explained.push_back(pca.explained(k));
    errors.push_back(pca.rms_error_mm(k));
  }
  for (Index f = 0; f < pca.scores.rows(); ++f) {
    for (Index k = 0; k < pca.scores.cols(); ++k) scores.push_back(pca.scores(f, k));
  }
  npz.add("explained", {modes}, std::span<const double>(explained));
  npz.add("rms_error_mm", {modes}, std::span<const double>(errors));
  npz.add("total_variance", pca.total_variance);
  npz.add("scores", {frames, modes}, std::span<const double>(scores));
  npz.add("sources", std::span<const std::string>(basis.sources));
  const std::vector<int64_t> counts(basis.frame_counts.begin(), basis.frame_counts.end());
  npz.add("frame_counts", {counts.size()}, std::span<const int64_t>(counts));
  std::vector<int64_t> faces;
  for (const Triangle& t : basis.topology->faces()) faces.insert(faces.end(), t.begin(), t.end());
  npz.add("faces", {basis.topology->face_count(), 3}, std::span<const int64_t>(faces));
  npz.write(path);
}

ExpressionBasis read_expression_basis(const std::filesystem::path& path) {
  const NpzFile file = read_npz(path);
  const auto& modes_shape = npz_array(file, "modes").shape;
  if (modes_shape.size() != 3 || modes_shape[2] != 3 || modes_shape[1] == 0) {
    malformed(path, "the array 'modes' is not modes x vertices x 3");
  }
  const std::size_t modes = modes_shape[0], vertices = modes_shape[1];
  ExpressionBasis basis;
  basis.pca.vertex_count = vertices;
  const auto mean = numbers_of(path, file, "mean", {vertices, 3});
  basis.pca.mean =
      Eigen::Map<const Eigen::VectorXd>(mean.data(), static_cast<Index>(mean.size())).cast<float>();
  const auto shapes = numbers_of(path, file, "modes", modes_shape);
  basis.pca.modes = Eigen::Map<const Eigen::MatrixXd>(
                        shapes.data(), static_cast<Index>(3 * vertices), static_cast<Index>(modes))
                        .cast<float>();
  const auto variances = numbers_of(path, file, "variances", {modes});
  basis.pca.variances =
      Eigen::Map<const Eigen::VectorXd>(variances.data(), static_cast<Index>(modes));
  basis.pca.total_variance = numbers_of(path, file, "total_variance", {}).front();
  const auto& faces_shape = npz_array(file, "faces").shape;
  if (faces_shape.size() != 2 || faces_shape[1] != 3) malformed(path, "'faces' is not n x 3");
  const auto corners = numbers_of(path, file, "faces", faces_shape);
  std::vector<Triangle> faces(faces_shape[0]);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (corners[i] < 0.0 || corners[i] >= static_cast<double>(vertices)) {
      malformed(path, "a face names a vertex that does not exist");
    }
    faces[i / 3][i % 3] = static_cast<VertexIndex>(corners[i]);
  }
  basis.topology = Topology::create(vertices, std::move(faces));
  return basis;
}

std::string scores_csv(const ExpressionScores& scores, double rate_hz, int64_t first_frame) {
  std::string csv = "frame,time_s,rms_error_mm";
  for (Index k = 0; k < scores.scores.cols(); ++k) csv += ",mode_" + std::to_string(k + 1);
  csv += "\n";
  for (Index f = 0; f < scores.scores.rows(); ++f) {
    append_number(csv, first_frame + static_cast<int64_t>(f));
    csv += ',';
    append_number(csv, rate_hz > 0.0 ? static_cast<double>(f) / rate_hz : 0.0);
    csv += ',';
    append_number(csv, scores.rms_error_mm[f]);
    for (Index k = 0; k < scores.scores.cols(); ++k) {
      csv += ',';
      append_number(csv, scores.scores(f, k));
    }
    csv += '\n';
  }
  return csv;
}

}  // namespace kinemesh
