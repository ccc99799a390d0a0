// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "rastro/base/log.h"
#include "rastro/base/task_pool.h"
#include "rastro/cli/command.h"
#include "rastro/cli/common_flags.h"
#include "rastro/cli/interrupt.h"
#include "rastro/dataset/open.h"
#include "rastro/synthetic/occluder/occluded_copy.h"

namespace rastro::cli {
namespace {

constexpr const char* occlude_footer =
    R"(A textured post or person, a fifth to a third of the image wide, moves across the image from side to side, again and
again with pauses, from frame 8 to 10 on; a point at rest is occluded for about 4 to 12 frames at a time. What reappears
behind it is compared with a run on the original recording: see `rastro evaluate tracks --clean`. The same seed and data
give the same bytes.

Output, in EuRoC layout: mav0/cam0 (images, data.csv, sensor.yaml if the calibration is known), ground truth if known,
mav0/occluder (a mask per image, 255 where it is covered, and occluder.yaml).

Examples:
  rastro occlude MH_01_easy --out MH_01_occluded --seed 1
  rastro occlude kitti/00 --frames 0:100 --out kitti_occluded --seed 2 --force)";

struct OccludeFlags {
  DataFlags data;
  std::string out;
  bool force = false;
};

std::string as_json(const OccludedCopyResult& result, const std::string& folder) {
  nlohmann::ordered_json json;
  json["out"] = folder;
  json["frames"] = result.frames;
  json["skipped"] = result.skipped;
  json["covered_frames"] = result.covered_frames;
  json["covered_share"] = result.covered_share;
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

void occlude(const OccludeFlags& flags) {
  const std::unique_ptr<Source> source = rastro::open(flags.data.path, open_options(flags.data));
  if (!source->info().has_image) throw Error("has no images", flags.data.path, "give a recording of a camera");
  for (const std::string& warning : source->info().warnings) log_warning(warning);
  TaskPool pool(flags.data.threads);
  std::int64_t complete = 0;
  OccludedCopyResult result;
  catch_interrupts();
  try {
    result = write_occluded_copy(*source, flags.out, {flags.data.seed, flags.force}, pool, [&](std::int64_t frames) {
      complete = frames;
      stop_if_interrupted();
    });
  } catch (const Interrupted&) {
    if (!flags.data.quiet) fmt::print("interrupted: {} frames are complete in {}\n", complete, flags.out);
    return;
  }
  if (flags.data.json)
    fmt::print("{}", as_json(result, flags.out));
  else if (!flags.data.quiet)
    fmt::print(
        "{} frames written to {}; the occluder is visible in {} of them and covers {:.1f} % of the pixels on average\n",
        result.frames, flags.out, result.covered_frames, 100.0 * result.covered_share);
}

}  // namespace

void add_occlude_command(CLI::App& app, Context& context) {
  CLI::App* command =
      app.add_subcommand("occlude", "Copies a recording with a moving occluder drawn in, to test re-identification");
  const auto flags = std::make_shared<OccludeFlags>();
  add_data_flags(*command, flags->data);
  command->add_option("--out", flags->out, "Output folder")->type_name("DIR")->required();
  command->add_flag("--force", flags->force, "Overwrite a former copy");
  command->footer(occlude_footer);
  command->callback([flags, &context] {
    if (flags->data.quiet) set_log_sink({});
    occlude(*flags);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
