#include "analysis/comparison/compare_files.h"

#include "config/input_file.h"
#include "config/output_file.h"
#include "mesh/surface_map_io.h"
#include "reconstruct/anonymous.h"

namespace kinemesh {
namespace {

namespace fs = std::filesystem;

Provenance provenance_of(const CompareJob& job, const ComparisonStory& story) {
  Provenance p;
  p.program = job.program;
  p.command = job.command;
  p.options = job.options_toml;
  p.inputs = {{job.a, story.a.sha256}, {job.b, story.b.sha256}};
  for (const std::string& path : {job.map, job.landmarks, job.regions, job.measures, job.truth}) {
    if (!path.empty()) p.inputs.push_back({path, sha256_of_file(path)});
  }
  return p;
}

std::string stem_of(const std::string& path) {
  const fs::path p(path);
  return (p.has_filename() ? p : p.parent_path()).stem().string();
}

/// Replaces the names that belong to one side in every text.
void hide_names(ComparisonStory& story, const CompareJob& job) {
  for (auto [side, path, name] : {std::tuple{&story.a, &job.a, "A"}, {&story.b, &job.b, "B"}}) {
    Anonymiser hidden(side->session);
    hidden.add_path(*path, name + fs::path(*path).extension().string());
    hidden.add(stem_of(*path), name);
    hidden.add_path(job.output, "comparison.html");
    for (const std::string& other : {job.map, job.landmarks, job.regions, job.measures, job.truth})
      hidden.add_path(other, "file" + fs::path(other).extension().string());
    for (std::string& label : side->mesh.vertex_names) label = hidden(label);
    for (std::string& note : side->notes) note = hidden(note);
    for (std::string& warning : story.comparison.warnings) warning = hidden(warning);
    for (Provenance::Input& input : story.provenance.inputs) input.path = hidden(input.path);
    story.provenance.command = hidden(story.provenance.command);
    story.provenance.options = hidden(story.provenance.options);
  }
  story.name_a = "first performance";
  story.name_b = "second performance";
}

/// Those of the user first, then those that every pair has.
std::vector<MeasureSpec> measures_of(const CompareJob& job, const ComparisonStory& story) {
  std::vector<MeasureSpec> specs;
  if (!job.measures.empty()) specs = read_measures(job.measures);
  const std::vector<MeasureSpec> usual = default_measures(story.a, story.b);
  specs.insert(specs.end(), usual.begin(), usual.end());
  return specs;
}

ComparisonStory tell(const FormatRegistry& formats, const CompareJob& job,
                     const CompareOptions& options, const RunContext& ctx) {
  ComparisonStory story;
  story.a = read_performance(formats, job.a, options.performance, ctx.part(0.0, 0.15, "reading A"));
  story.b = read_performance(formats, job.b, options.performance, ctx.part(0.15, 0.3, "reading B"));
  const Topology &of_a = story.a.mesh.topology(), &of_b = story.b.mesh.topology();
  // Everything is read before the long part begins: what is wrong with it is said at once.
  std::vector<LandmarkPair> landmarks;
  if (!job.landmarks.empty()) landmarks = read_landmark_pairs(job.landmarks, of_a, of_b);
  std::optional<SurfaceMap> map, truth;
  if (!job.map.empty()) map = read_surface_map(job.map);
  if (!job.truth.empty()) truth = read_surface_map(job.truth);
  const std::vector<SurfaceRegion> regions =
      job.regions.empty() ? default_regions(story.a.mesh) : read_regions(job.regions, story.a.mesh);
  const std::vector<MeasureSpec> specs = measures_of(job, story);
  const double window = options.comparison.rest_window_s;
  Comparison& c = story.comparison =
      compare_performances(story.a.mesh, story.b.mesh, options.comparison,
                           ctx.part(0.3, 0.8, "comparison"), landmarks, map ? &*map : nullptr);
  story.regions = compare_regions(c, of_b, regions, window);
  story.measures = take_measures(c, story.a, story.b, specs, window);
  story.asymmetry = asymmetry_of(story.regions, story.measures);
  if (truth) {
    story.truth = evaluate_map(c.forward, truth_from_map(*truth), story.b.mesh.mesh_at(0),
                               {.samples = 1000}, ctx);
  }
  return story;
}

fs::path beside(const fs::path& page, const std::string& suffix) {
  return page.parent_path() / (page.stem().string() + suffix);
}

}  // namespace

void CompareOptions::declare(ParameterSet& p) {
  p.group("privacy", "Privacy");
  p.flag("anonymous", anonymous, "Leave names of subjects and files out of all that is written");
  comparison.declare(p);
  performance.declare(p);
}

void CompareOptions::validate() const {
  comparison.validate();
  performance.validate();
}

CompareFilesResult compare_files(const FormatRegistry& formats, const CompareJob& job,
                                 const CompareOptions& options, const RunContext& ctx) {
  options.validate();
  CompareFilesResult result;
  ComparisonStory& story = result.story = tell(formats, job, options, ctx.part(0.0, 0.8, ""));
  story.name_a = stem_of(job.a);
  story.name_b = stem_of(job.b);
  story.provenance = provenance_of(job, story);
  if (options.anonymous) hide_names(story, job);
  OutputSet files;
  const fs::path page = job.output;
  files.add(page, comparison_html(story, ctx.part(0.8, 1.0, "report")));
  files.add(beside(page, ".json"), comparison_json(story));
  files.add(beside(page, "_measures.csv"), measures_csv(story));
  files.add(beside(page, "_regions.csv"), regions_csv(story));
  files.add(beside(page, "_curves.csv"), curves_csv(story));
  result.outputs = files.paths();
  refuse_to_replace({job.a, job.b, job.map, job.landmarks, job.regions, job.measures, job.truth},
                    result.outputs);
  files.commit();
  return result;
}

}  // namespace kinemesh
