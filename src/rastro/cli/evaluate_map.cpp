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

constexpr const char* evaluate_map_footer =
    R"(RUN is a run folder (its map.yaml) or the .yaml of an occupancy grid; GROUND_TRUTH is the .yaml of the true floor plan. Both
are in the format of ROS map_server and in the same frame (a run's begins at its first pose unless --initial-pose was
given), up to --align.
  precision       share of the run's occupied cells within the tolerance of an occupied cell of the ground truth
  recall          share of the ground truth's occupied cells (next to a free one) within the tolerance of one of the run
  recall_seen     recall near cells that the run observed: unexplored parts are left out
  iou             intersection over union of occupied cells: 1 / (1 / precision + 1 / recall_seen - 1)
  free_agreement  share of the run's free cells, where the ground truth is known, within the tolerance of a free one
  explored        share of the ground truth's free cells that are free in the run's map
  shift_x, shift_y, turn_deg   translation (m) and rotation (deg) that --align se2 found

Examples:
  rastro evaluate map run corridor/floor_plan.yaml
  rastro evaluate map run/map.yaml corridor/floor_plan.yaml --align se2 --json --require 'iou>=0.8')";

struct EvaluateMapFlags {
  std::string run, ground_truth, align = "none";
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
          {"truth_occupied", static_cast<double>(agreement.ground_truth_occupied)},
          {"truth_seen", static_cast<double>(agreement.ground_truth_seen)},
          {"shift_x", agreement.ground_truth_from_map.translation().x()},
          {"shift_y", agreement.ground_truth_from_map.translation().y()},
          {"turn_deg", agreement.ground_truth_from_map.rotation().angle() * 180.0 / std::numbers::pi}};
}

std::string text_of(const GridAgreement& agreement) {
  std::string text;
  for (const auto& [name, value] : numbers_of(agreement))
    text += fmt::format("{:<15} {}\n", name, std::round(value * 1e4) / 1e4);
  return text;
}

GridAgreementOptions options_of(const EvaluateMapFlags& flags) {
  GridAgreementOptions options;
  if (flags.align != "none" && flags.align != "se2")
    throw Error(in_quotes(flags.align) + " is not an alignment of maps", "--align", "give none or se2");
  options.align = flags.align == "se2";
  if (!(flags.tolerance_cells >= 0.0 && flags.tolerance_cells <= 100.0))
    throw Error(fmt::format("{} is out of range", flags.tolerance_cells), "--tolerance", "give 0 to 100 cells");
  options.tolerance_cells = flags.tolerance_cells;
  return options;
}

std::string map_file(const std::string& run) {
  std::error_code ignored;
  return std::filesystem::is_directory(run, ignored) ? (std::filesystem::path(run) / "map.yaml").string() : run;
}

int evaluate_map(const EvaluateMapFlags& flags) {
  const GridAgreementOptions options = options_of(flags);
  const std::vector<ScoreLimit> limits = parse_limits(flags.limits, numbers_of({}), "'iou>=0.8'");
  const OccupancyGrid map = read_map_server(map_file(flags.run)),
                      ground_truth = read_map_server(map_file(flags.ground_truth));
  const GridAgreement agreement = grid_agreement(map, ground_truth, options);
  if (flags.json)
    fmt::print("{}", as_json(numbers_of(agreement)));
  else if (!flags.quiet)
    fmt::print("{}", text_of(agreement));
  return report_missed(limits, numbers_of(agreement));
}

}  // namespace

void add_evaluate_map_command(CLI::App& evaluate, Context& context) {
  CLI::App* command = evaluate.add_subcommand("map", "Agreement of a 2D occupancy grid with the true floor plan");
  const auto flags = std::make_shared<EvaluateMapFlags>();
  command->add_option("RUN", flags->run, "Run folder or .yaml of an occupancy grid")->type_name("")->required();
  command->add_option("GROUND_TRUTH", flags->ground_truth, ".yaml of the true occupancy grid")
      ->type_name("")
      ->required();
  command->add_option("--align", flags->align, "se2: align the map, by up to 1 m and 5 degrees (default: none)")
      ->type_name("none|se2");
  command->add_option("--tolerance", flags->tolerance_cells, "Tolerance in cells of the coarser grid (default: 1)")
      ->type_name("N");
  command->add_option("--require", flags->limits, "Limit, such as 'iou>=0.8'; exit code 1 if missed; may be repeated")
      ->type_name("LIMIT")
      ->allow_extra_args(false);
  command->add_flag("--json", flags->json, "Print the result as JSON");
  command->add_flag("--quiet", flags->quiet, "Print errors and warnings only");
  command->footer(evaluate_map_footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    context.exit_code = evaluate_map(*flags);
  });
}

}  // namespace rastro::cli
