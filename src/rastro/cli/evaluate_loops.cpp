// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/evaluate_loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text_file.h"
#include "rastro/cli/limits.h"
#include "rastro/cli/map_path.h"
#include "rastro/dataset/open.h"
#include "rastro/evaluate/loop_closures.h"
#include "rastro/map/file/map_file.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* evaluate_loops_footer =
    R"(RUN is a run folder or a map file, RECORDING the generated recording that it was made from, with closures.yaml.
  accepted   constraints of the map between keyframes at least --gap apart in time
  wrong      of these, those whose relative pose is off by more than --max-error or --max-angle; the first eight:
             the two keyframes, when, how far it is off, and the kind of constraint
  precision  share of the accepted that is right
  revisits   frames that see a place again, by closures.yaml
  found      of these, those that a right constraint closes, or that the map holds relative to an old keyframe
  recall     share of the revisits that is found
  missed     the other revisits, the first eight: when, and when the place was seen before, in seconds since the
             first pose of the ground truth
--json: accepted, wrong, unknown (without ground truth), precision, revisits, found and recall.

Examples:
  rastro evaluate loops run campus
  rastro evaluate loops run campus --json --require 'wrong<=0' --require 'recall>=0.9')";

struct EvaluateLoopsFlags {
  std::string run, recording;
  LoopClosureLimits loops;
  std::vector<std::string> limits;
  bool json = false, quiet = false;
};

NamedNumbers numbers_of(const LoopClosureScores& scores) {
  return {{"accepted", static_cast<double>(scores.accepted)},
          {"wrong", static_cast<double>(scores.wrong)},
          {"unknown", static_cast<double>(scores.unknown)},
          {"precision", scores.precision()},
          {"revisits", static_cast<double>(scores.revisits)},
          {"found", static_cast<double>(scores.found)},
          {"recall", scores.recall()}};
}

std::string text_of_wrong(const std::vector<WrongClosure>& wrong, TimeNs start) {
  constexpr std::size_t most = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(most, wrong.size()); ++i) {
    const WrongClosure& each = wrong[i];
    text +=
        fmt::format("wrong      keyframes {} ({:.1f} s) and {} ({:.1f} s): {:.2f} m, {:.1f} degrees off ({})\n",
                    std::min(each.from, each.to), to_seconds(each.earlier_stamp - start), std::max(each.from, each.to),
                    to_seconds(each.stamp - start), each.error_m, each.error_deg, name_of(each.kind));
  }
  if (wrong.size() > most) text += fmt::format("           and {} more\n", wrong.size() - most);
  return text;
}

/// Of the first: when, and when the place was seen before, in seconds since the recording's start.
std::string text_of_missed(const std::vector<Revisit>& missed, TimeNs start) {
  constexpr std::size_t most = 8;
  std::string text = "missed     ";
  for (std::size_t i = 0; i < std::min(most, missed.size()); ++i)
    text += fmt::format("{}{:.1f} s (place of {:.1f} s)", i == 0 ? "" : ", ", to_seconds(missed[i].stamp - start),
                        to_seconds(missed[i].earlier_stamp - start));
  if (missed.size() > most) text += fmt::format(" and {} more", missed.size() - most);
  return text + "\n";
}

std::string text_of(const LoopClosureScores& scores, TimeNs start) {
  std::string text = fmt::format("accepted   {} loop closures, {} wrong: precision {:.2f} %\n", scores.accepted,
                                 scores.wrong, 100.0 * scores.precision());
  text += text_of_wrong(scores.wrong_ones, start);
  text +=
      fmt::format("revisits   {}, found {}: recall {:.1f} %\n", scores.revisits, scores.found, 100.0 * scores.recall());
  if (!scores.missed.empty()) text += text_of_missed(scores.missed, start);
  if (scores.unknown > 0) text += fmt::format("unknown    {} without ground truth\n", scores.unknown);
  return text;
}

void check(const EvaluateLoopsFlags& flags) {
  const double gap_s = flags.loops.gap_s, error_m = flags.loops.max_error_m, error_deg = flags.loops.max_error_deg;
  if (!(gap_s > 0.0 && gap_s <= 1e6)) throw Error("is not a time difference", "--gap", "give seconds, such as 15");
  if (!(error_m > 0.0 && error_m <= 1e6)) throw Error("is not a distance", "--max-error", "give meters, such as 0.5");
  if (!(error_deg > 0.0 && error_deg <= 180.0))
    throw Error("is not an angle", "--max-angle", "give degrees, such as 10");
}

int evaluate_loops(const EvaluateLoopsFlags& flags) {
  check(flags);
  const std::vector<ScoreLimit> limits = parse_limits(flags.limits, numbers_of({}), "'recall>=0.9'");
  const std::string list = (fs::path(flags.recording) / "closures.yaml").string();
  const std::vector<Revisit> revisits = parse_revisits(read_text_file(list), list);
  const SourceInfo info = open(flags.recording)->info();
  if (info.ground_truth.empty()) throw Error("has no ground truth", flags.recording, "give a generated recording");
  const std::shared_ptr<const Map> map = load_map(map_file_of(flags.run));
  const LoopClosureScores scores = score_loop_closures(*map, revisits, camera_ground_truth(info), flags.loops);
  if (flags.json)
    fmt::print("{}", as_json(numbers_of(scores)));
  else if (!flags.quiet)
    fmt::print("{}", text_of(scores, info.ground_truth.front().stamp));
  return report_missed(limits, numbers_of(scores));
}

}  // namespace

void add_evaluate_loops_command(CLI::App& evaluate, Context& context) {
  CLI::App* command = evaluate.add_subcommand("loops", "Precision and recall of the loop closures in a map");
  const auto flags = std::make_shared<EvaluateLoopsFlags>();
  command->add_option("RUN", flags->run, "Run folder or map file")->type_name("")->required();
  command->add_option("RECORDING", flags->recording, "Generated recording with closures.yaml")
      ->type_name("")
      ->required();
  command->add_option("--gap", flags->loops.gap_s, "Minimum distance in time, seconds")
      ->type_name("S")
      ->capture_default_str();
  command->add_option("--max-error", flags->loops.max_error_m, "Largest error of a right loop closure, meters")
      ->type_name("M")
      ->capture_default_str();
  command->add_option("--max-angle", flags->loops.max_error_deg, "The same of its rotation, degrees")
      ->type_name("DEG")
      ->capture_default_str();
  command
      ->add_option("--require", flags->limits, "Limit, such as 'recall>=0.9'; exit code 1 if missed; may be repeated")
      ->type_name("LIMIT")
      ->allow_extra_args(false);
  command->add_flag("--json", flags->json, "Print the result as JSON");
  command->add_flag("--quiet", flags->quiet, "Print errors and warnings only");
  command->footer(evaluate_loops_footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    context.exit_code = evaluate_loops(*flags);
  });
}

}  // namespace rastro::cli
