// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/evaluate_map.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/limits.h"
#include "rastro/evaluate/grid_agreement.h"
#include "rastro/export/grid_map_server.h"

namespace rastro::cli {
namespace {

constexpr const char* footer =
    R"(RUN is the folder of a run (its map.yaml) or the .yaml of a map; TRUTH is the .yaml of the true floor plan. Both are read as ROS's
map_server does, and stand in one frame (that of a run is where it started) but for what --align finds.

  precision       of the run's occupied cells, those within the tolerance of an occupied cell of the truth
  recall          of the truth's occupied cells with a free one beside them, those within the tolerance of one of the run
  recall_seen     the same of those near a cell that the run knows: places it never came to are left out
  iou             of occupied cells: 1 / (1 / precision + 1 / recall_seen - 1)
  free_agreement  of the run's free cells where the truth is known, those within the tolerance of a free one
  explored        of the truth's free cells, those that are free in the run's map
  shift, turn     what --align se2 found, about the middle of the map

Examples:
  rastro evaluate map run corridor/floor_plan.yaml
  rastro evaluate map run/map.yaml corridor/floor_plan.yaml --align se2 --json --require 'iou>=0.8')";

struct Flags {
  std::string run, truth, align = "none";
  double tolerance_cells = 1.0;
  std::vector<std::string> limits;
  bool json = false, quiet = false;
};

NamedNumbers numbers_of(const GridAgreement& agreement) {
  return {{"precision", agreement.precision},
          {"recall", agreement.recall},
          {"recall_seen", agreement.recall_seen},
          {"iou", agreement.iou},
          {"free_agreement", agreement.free_agreement},
          {"explored", agreement.explored},
          {"map_occupied", static_cast<double>(agreement.map_occupied)},
          {"truth_occupied", static_cast<double>(agreement.truth_occupied)},
          {"truth_seen", static_cast<double>(agreement.truth_seen)},
          {"shift_x", agreement.truth_from_map.translation().x()},
          {"shift_y", agreement.truth_from_map.translation().y()},
          {"turn_deg", agreement.truth_from_map.rotation().angle() * 180.0 / std::numbers::pi}};
}

std::string text_of(const GridAgreement& agreement) {
  std::string text;
  for (const auto& [name, value] : numbers_of(agreement))
    text += fmt::format("{:<15} {}\n", name, std::round(value * 1e4) / 1e4);
  return text;
}

GridAgreementOptions options_of(const Flags& flags) {
  GridAgreementOptions options;
  if (flags.align != "none" && flags.align != "se2")
    throw Error(in_quotes(flags.align) + " is no alignment of maps", "--align", "use none or se2");
  options.align = flags.align == "se2";
  if (!(flags.tolerance_cells >= 0.0 && flags.tolerance_cells <= 100.0))
    throw Error(fmt::format("{} is no number of cells", flags.tolerance_cells), "--tolerance", "give 0 to 100");
  options.tolerance_cells = flags.tolerance_cells;
  return options;
}

std::string map_file(const std::string& run) {
  std::error_code ignored;
  return std::filesystem::is_directory(run, ignored) ? (std::filesystem::path(run) / "map.yaml").string() : run;
}

int evaluate_map(const Flags& flags) {
  const GridAgreementOptions options = options_of(flags);
  const std::vector<ScoreLimit> limits = parse_limits(flags.limits, numbers_of({}), "'iou>=0.8'");
  const OccupancyGrid map = read_map_server(map_file(flags.run)), truth = read_map_server(map_file(flags.truth));
  const GridAgreement agreement = grid_agreement(map, truth, options);
  if (flags.json)
    fmt::print("{}", as_json(numbers_of(agreement)));
  else if (!flags.quiet)
    fmt::print("{}", text_of(agreement));
  return report_missed(limits, numbers_of(agreement));
}

}  // namespace

void add_evaluate_map_command(CLI::App& evaluate, Context& context) {
  CLI::App* command = evaluate.add_subcommand("map", "How a 2D map agrees with the true floor plan");
  const auto flags = std::make_shared<Flags>();
  command->add_option("RUN", flags->run, "Run folder or .yaml of a map")->required();
  command->add_option("TRUTH", flags->truth, ".yaml of the true map")->required();
  command->add_option("--align", flags->align, "se2: look for a better place within 1 m and 5 degrees (default: none)")
      ->type_name("none|se2");
  command->add_option("--tolerance", flags->tolerance_cells, "In cells of the coarser map (default: 1)")
      ->type_name("N");
  command->add_option("--require", flags->limits, "Limit such as 'iou>=0.8'; exit code 1 when one is missed")
      ->type_name("LIMIT")
      ->allow_extra_args(false);
  command->add_flag("--json", flags->json, "Print JSON");
  command->add_flag("--quiet", flags->quiet, "Print nothing but what goes wrong");
  command->footer(footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    context.exit_code = evaluate_map(*flags);
  });
}

}  // namespace rastro::cli
