// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/evaluate_relations.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/cli/limits.h"
#include "rastro/evaluate/relations.h"
#include "rastro/evaluate/trajectory_input.h"

namespace rastro::cli {
namespace {

constexpr const char* evaluate_relations_footer =
    R"(RUN is a run folder (its trajectory.txt) or a trajectory file with timestamps. FILE has lines of
"stamp_a stamp_b x y z roll pitch yaw": the pose of the body at b relative to that at a (seconds, meters, radians).
  error       of a relation: relation^-1 * (a^-1 * b of the run), Kuemmerle et al. 2009; without alignment
  trans, rot  mean and standard deviation of its translation (m) and rotation (deg)
  skipped     relations without a pose of the run within --max-dt of a timestamp; do not rank runs that skip different ones
--json: relations, trans_mean, trans_sigma, rot_mean_deg, rot_sigma_deg, skipped and trans_max.

Examples:
  rastro evaluate relations run --relations intel.relations
  rastro evaluate relations run --relations intel.relations --json --require 'trans_mean<=0.03' --require 'skipped<=0')";

struct EvaluateRelationsFlags {
  std::string run, relations;
  double max_dt_s = 0.05;
  std::vector<std::string> limits;
  bool json = false, quiet = false;
};

NamedNumbers numbers_of(const RelationScores& scores) {
  return {{"relations", static_cast<double>(scores.relations)},
          {"trans_mean", scores.trans_mean_m},
          {"trans_sigma", scores.trans_sigma_m},
          {"rot_mean_deg", scores.rot_mean_deg},
          {"rot_sigma_deg", scores.rot_sigma_deg},
          {"skipped", static_cast<double>(scores.skipped)},
          {"trans_max", scores.worst_trans_m}};
}

std::string text_of(const RelationScores& scores, const std::string& run) {
  std::string text = fmt::format("run          {}\nrelations    {} evaluated, {} skipped\n", one_line(run),
                                 scores.relations, scores.skipped);
  text += fmt::format("translation  mean {:.4f} m, sigma {:.4f} m, largest {:.3f} m\n", scores.trans_mean_m,
                      scores.trans_sigma_m, scores.worst_trans_m);
  text += fmt::format("rotation     mean {:.4f} deg, sigma {:.4f} deg\n", scores.rot_mean_deg, scores.rot_sigma_deg);
  if (scores.worst_dt > 1'000'000)
    text += fmt::format("stamps       up to {:.3f} s apart\n", to_seconds(scores.worst_dt));
  return text;
}

int evaluate_relations(const EvaluateRelationsFlags& flags) {
  const std::vector<ScoreLimit> limits = parse_limits(flags.limits, numbers_of({}), "'trans_mean<=0.03'");
  if (!(flags.max_dt_s >= 0.0 && flags.max_dt_s <= 1e6))
    throw Error(fmt::format("{} is not a time difference", flags.max_dt_s), "--max-dt", "give seconds, such as 0.05");
  const std::vector<Relation> relations = parse_relations(read_text_file(flags.relations), flags.relations);
  std::error_code ignored;
  const std::filesystem::path run(flags.run);
  const bool is_folder = std::filesystem::is_directory(run, ignored);
  const TrajectoryInput input = read_trajectory_input((is_folder ? run / "trajectory.txt" : run).string());
  if (!input.has_stamps) throw Error("has no timestamps", input.file, "give a file in TUM format");
  const RelationScores scores = score_relations(relations, input.poses, from_seconds(flags.max_dt_s));
  if (scores.relations == 0) {
    throw Error(fmt::format("no pose is within {1} s of any of its {0} relations in {2}", relations.size(),
                            flags.max_dt_s, one_line(input.file)),
                flags.relations, "check that both are of the same recording");
  }
  if (flags.json)
    fmt::print("{}", as_json(numbers_of(scores)));
  else if (!flags.quiet)
    fmt::print("{}", text_of(scores, describe(input)));
  return report_missed(limits, numbers_of(scores));
}

}  // namespace

void add_evaluate_relations_command(CLI::App& evaluate, Context& context) {
  CLI::App* command =
      evaluate.add_subcommand("relations", "Error of known relative poses: the metric of the 2D SLAM benchmarks");
  const auto flags = std::make_shared<EvaluateRelationsFlags>();
  command->add_option("RUN", flags->run, "Run folder or trajectory file")->type_name("")->required();
  command->add_option("--relations", flags->relations, "File of known relative poses")->type_name("FILE")->required();
  command
      ->add_option("--max-dt", flags->max_dt_s,
                   "Maximum time difference of a pose and a timestamp in seconds (default: 0.05)")
      ->type_name("S");
  command
      ->add_option("--require", flags->limits,
                   "Limit, such as 'trans_mean<=0.03'; exit code 1 if missed; may be repeated")
      ->type_name("LIMIT")
      ->allow_extra_args(false);
  command->add_flag("--json", flags->json, "Print the result as JSON");
  command->add_flag("--quiet", flags->quiet, "Print errors and warnings only");
  command->footer(evaluate_relations_footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    context.exit_code = evaluate_relations(*flags);
  });
}

}  // namespace rastro::cli
