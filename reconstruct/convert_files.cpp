#include "reconstruct/convert_files.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include "capture/clean.h"
#include "capture/edit_list.h"
#include "config/changed_parameters.h"
#include "config/error.h"
#include "config/output_file.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"
#include "reconstruct/anonymous.h"
#include "reconstruct/convert_report.h"
#include "reconstruct/output_names.h"
#include "report/gap_chart.h"
#include "report/image.h"

namespace kinemesh {
namespace {

namespace fs = std::filesystem;

Anonymiser anonymiser_of(const ConvertJob& job, const MarkerSequence& session) {
  Anonymiser anonymiser(session);
  anonymiser.add_path(job.session, "session" + fs::path(job.session).extension().string());
  anonymiser.add_path(job.previous, "previous" + fs::path(job.previous).extension().string());
  anonymiser.add_path(job.edits, "edits.toml");
  anonymiser.add_path(job.output, "mesh" + fs::path(job.output).extension().string());
  anonymiser.add(stem_of_output(job.output).filename().string(), "mesh");
  return anonymiser;
}

/// What is written about one conversion, and where to.
class Writer {
 public:
  Writer(const ConvertJob& job, const ConvertFilesOptions& options, ConvertFilesResult& result)
      : job_(job), options_(options), result_(result), stem_(stem_of_output(job.output)) {}

  void write(const FormatRegistry& formats, const RunContext& ctx) {
    title_ = fs::path(result_.session.origin.path).filename().string();
    const WriteResult written =
        add_animation(formats, result_.conversion.animation, job_.output, writing(), files_,
                      ctx.part(0.0, 0.4, "writing the mesh"));
    for (const std::string& note : written.report.notes) ctx.info(note);
    result_.written.format = written.format;
    result_.written.lost = written.report.lost;
    result_.written.max_error_mm = written.report.max_error_mm;
    result_.written.rms_error_mm = written.report.rms_error_mm;
    for (const fs::path& file : written.files) {
      result_.written.mesh_files.push_back(file.string());
    }
    list(written.files.front());
    if (written.files.size() > 1) list(written.files.back());
    if (options_.pictures) draw(ctx.part(0.4, 0.7, "drawing"));
    add("_quality.csv", quality_csv(result_.conversion));
    list(beside(stem_, "_summary.json"));
    if (options_.report) add_report(ctx.part(0.7, 1.0, "report"));
    files_.add(beside(stem_, "_summary.json"),
               summary_json(result_.session, result_.conversion, shown()));
    refuse_to_replace({job_.session, job_.previous, job_.edits}, files_.paths());
    files_.commit();
  }

  /// Files with axes of their own are turned by those that the session names.
  WriteOptions writing() const {
    WriteOptions all = options_.writing;
    if (all.gltf.up == GltfUp::automatic && result_.session.origin.y_screen == "+Y") {
      all.gltf.up = GltfUp::y;
    }
    return all;
  }

  /// Set when no name may be written.
  std::optional<Anonymiser> anonymiser;

 private:
  void list(const fs::path& path) { result_.written.outputs.push_back(path.string()); }
  void add(const std::string& suffix, const std::string& content) {
    list(beside(stem_, suffix));
    files_.add(beside(stem_, suffix), content);
  }

  /// The outputs as the written files may name them.
  WrittenMesh shown() const {
    WrittenMesh shown = result_.written;
    if (!anonymiser) return shown;
    for (auto* paths : {&shown.outputs, &shown.mesh_files}) {
      for (std::string& path : *paths) path = (*anonymiser)(fs::path(path).filename().string());
    }
    return shown;
  }

  void draw(const RunContext& ctx) {
    const ConvertResult& conversion = result_.conversion;
    ContactSheetOptions sheet = options_.sheet;
    sheet.title = title_;
    sheet.subtitle = count_of(conversion.markers.size(), "marker") + ", " +
                     count_of(conversion.animation.frame_count(), "frame") + " at " +
                     format_number(conversion.animation.rate_hz) + " Hz";
    const Canvas frames = draw_contact_sheet(conversion.animation, sheet, ctx).sheet;
    add("_frames.png", encode_png(frames.raster(png_scale(frames))));
    ctx.check_cancelled();
    GapChart chart = gap_chart_of(conversion);
    chart.subtitle = title_;
    const Canvas gaps = draw_gap_chart(chart);
    add("_gaps.png", encode_png(gaps.raster(png_scale(gaps))));
    ctx.check_cancelled();
    ctx.progress(1.0);
  }

  void add_report(const RunContext& ctx) {
    list(beside(stem_, "_report.html"));
    const ConvertReport report = convert_report(result_.session, result_.conversion,
                                                {.title = title_,
                                                 .outputs = shown().outputs,
                                                 .mesh_max_error_mm = result_.written.max_error_mm,
                                                 .mesh_rms_error_mm = result_.written.rms_error_mm,
                                                 .up = direction_of(options_.sheet.up)},
                                                ctx);
    result_.report_error_mm = report.max_error_mm;
    files_.add(beside(stem_, "_report.html"), report.html);
    ctx.check_cancelled();
    ctx.progress(1.0);
  }

  const ConvertJob& job_;
  const ConvertFilesOptions& options_;
  ConvertFilesResult& result_;
  fs::path stem_;
  std::string title_;
  OutputSet files_;
};

/// What the reader found wrong is doubtful in the mesh, too. The first few tell enough.
void pass_on(std::vector<std::string> findings, std::vector<std::string>& warnings) {
  constexpr std::size_t most = 6;
  if (findings.size() > most) {
    const std::string rest = std::to_string(findings.size() - most);
    findings.resize(most);
    findings.push_back(rest + " more findings in the file: see 'kinemesh c3d check'");
  }
  warnings.insert(warnings.begin(), findings.begin(), findings.end());
}

}  // namespace

void ConvertFilesOptions::declare(ParameterSet& p) {
  reading.declare(p);
  convert.declare(p);
  writing.declare(p);
  p.group("pictures", "Pictures and report");
  p.flag("pictures", pictures, "draw the mesh at a few frames, and the gaps over time");
  p.flag("report", report, "write a report as one HTML page that works offline");
  p.flag("anonymous", anonymous,
         "leave the names of subjects and files out of everything that is written");
  sheet.declare(p);
}

void ConvertFilesOptions::validate() const {
  convert.validate();
  validate_options(*this);
}

std::string default_output(const std::string& session, const std::string& extension) {
  std::string name = fs::path(session).stem().string();
  std::ranges::replace_if(
      name, [](char c) { return c == '#' || c == '%'; }, '-');
  return name + extension;
}

void refuse_session_options(const ConvertFilesOptions& options, const std::string& mesh) {
  const ConvertFilesOptions standard;
  ConvertFilesOptions given = options;
  given.writing = standard.writing;
  given.reading.c3d.unstated = standard.reading.c3d.unstated;
  given.anonymous = standard.anonymous;
  given.pictures = standard.pictures;  // there are none in any case
  given.report = standard.report;
  const std::vector<std::string> names = changed_options(given);
  if (names.empty()) return;
  throw UsageError({.what = mesh + " is a mesh: " + join(names, ", ", " and ") +
                            (names.size() > 1 ? " are" : " is") + " for sessions",
                    .remedy = "Give the session that was recorded, or leave this out"});
}

ConvertFilesResult convert_files(const FormatRegistry& formats, const ConvertJob& job,
                                 const ConvertFilesOptions& options, const RunContext& ctx) {
  options.validate();
  EditList steps;
  if (!job.edits.empty()) steps = read_edits(job.edits);
  std::vector<fs::path> inputs = files_read(steps);
  inputs.insert(inputs.end(), {job.session, job.previous, job.edits});
  refuse_to_replace(inputs, {job.output});
  ConvertFilesResult result;
  std::vector<std::string> findings;
  result.session =
      read_session(job.session, options.reading,
                   ctx.part(0.0, 0.1, "reading")
                       .overheard_by([&findings](LogLevel level, std::string_view text) {
                         if (level >= LogLevel::warning) findings.emplace_back(text);
                       }));
  if (!job.edits.empty()) {
    EditResult edited = apply_edits(result.session, steps, ctx);
    result.session = std::move(edited.take);
    for (const std::string& done : edited.done) ctx.info(done);
  }
  if (has_twins(result.session)) {
    EditList unite;
    unite.steps.push_back(make_edit("unite-twins", {}));
    EditResult united = apply_edits(result.session, unite, ctx);
    result.session = std::move(united.take);
    std::ranges::move(united.done, std::back_inserter(findings));
  }
  // A wrong name or format is said before the work is done, not after it.
  output_format(formats, job.output, options.writing, result.session.frame_count());
  std::optional<Mesh> previous;
  if (!job.previous.empty())
    previous = read_mesh(formats, job.previous, options.reading.c3d.unstated, ctx);
  result.conversion =
      convert_session(result.session, options.convert, previous, ctx.part(0.1, 0.7, "converting"));
  pass_on(std::move(findings), result.conversion.warnings);
  result.conversion.animation.provenance = provenance_of(job.program, job.command, job.options_toml,
                                                         {job.session, job.previous, job.edits});
  Writer writer(job, options, result);
  if (options.anonymous) {
    writer.anonymiser = anonymiser_of(job, result.session);
    anonymise(*writer.anonymiser, result.session, result.conversion);
  }
  writer.write(formats, ctx.part(0.7, 1.0, "writing"));
  ctx.progress(1.0);
  return result;
}

}  // namespace kinemesh
