// kinemesh c3d quality: is a take worth cleaning?
#include <filesystem>

#include "capture/quality.h"
#include "capture/session.h"
#include "cli/commands/commands.h"
#include "config/error.h"
#include "config/output_file.h"
#include "config/text.h"
#include "report/gap_chart.h"
#include "report/image.h"

namespace kinemesh::cli {

CommandSpec c3d_quality_command() {
  return {
      .path = "c3d quality",
      .summary = "Grade a take before anybody spends an hour on it",
      .example =
          "kinemesh c3d quality smile.c3d\n"
          "kinemesh c3d quality smile.c3d --picture smile.png --json",
      .setup = [](CommandLine& line) -> Action {
        struct Arguments {
          std::string file, picture;
          SessionReadOptions read;
          QualityOptions quality;
        };
        auto args = std::make_shared<Arguments>();
        line.positional("FILE", args->file, "C3D, TRC, CSV or TSV file");
        line.option("--picture", args->picture, "PNG", "Draw visibility, head motion, noise");
        line.parameters([args](ParameterSet& p) {
          args->read.declare(p);
          args->quality.declare(p);
        });
        line.json_output();
        return [args](Terminal& terminal) {
          const RunContext& run = terminal.run;
          if (!args->picture.empty() &&
              lower(std::filesystem::path(args->picture).extension().string()) != ".png") {
            throw UsageError(
                {.what = "the picture is a PNG, and '" + args->picture + "' does not end so",
                 .remedy = "Name it FILE.png"});
          }
          refuse_to_replace({args->file}, {args->picture});
          const MarkerSequence take =
              read_session(args->file, args->read, run.part(0.0, 0.2, "reading"));
          const QualityResult result =
              assess_take(take, args->quality, run.part(0.2, 0.9, "looking"));
          if (!args->picture.empty()) {
            const Canvas page =
                draw_quality(result, std::filesystem::path(args->file).filename().string());
            write_file(args->picture, encode_png(page.raster(png_scale(page))));
          }
          terminal.print(terminal.json ? quality_json(result, args->file) : quality_text(result));
          return ExitCode::done;
        };
      }};
}

}  // namespace kinemesh::cli
