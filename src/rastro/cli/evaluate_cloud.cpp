// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/evaluate_cloud.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/task_pool.h"
#include "rastro/cli/limits.h"
#include "rastro/evaluate/cloud_agreement.h"
#include "rastro/export/ply.h"

namespace rastro::cli {
namespace {

constexpr const char* evaluate_cloud_footer =
    R"(REF is a PLY of the true surfaces (truth.ply of `rastro simulate bedroom`) or of points; EST a PLY of points, such as
'rastro export --to ply' writes, or a run folder (its cloud.ply). Both are in the same frame, in meters; no alignment.
  mean median rms percentile_95 largest   distance of the points of EST from REF, m
  precision      share of the points of EST within the tolerance of REF
  completeness   share of REF within the tolerance of a point of EST, whether it was observed or not
  sigma_ratio    rms of distance / sigma: 1 if the sigmas are consistent, above 1 if they are overconfident

Examples:
  rastro evaluate cloud bedroom/truth.ply run
  rastro evaluate cloud truth.ply room.ply --tolerance 0.01 --json --require 'median<=0.01')";

struct EvaluateCloudFlags {
  std::string reference, estimate;
  CloudAgreementOptions options;
  std::vector<std::string> limits;
  int threads = 0;
  bool json = false, quiet = false;
};

NamedNumbers numbers_of(const CloudAgreement& agreement) {
  return {{"mean", agreement.mean},
          {"median", agreement.median},
          {"rms", agreement.rms},
          {"percentile_95", agreement.percentile_95},
          {"largest", agreement.largest},
          {"precision", agreement.precision},
          {"completeness", agreement.completeness},
          {"sigma_ratio", agreement.sigma_ratio},
          {"points", static_cast<double>(agreement.points)}};
}

int evaluate_cloud(const EvaluateCloudFlags& flags) {
  if (!(flags.options.tolerance_m > 0.0 && flags.options.tolerance_m <= 10.0))
    throw Error(fmt::format("{} is out of range", flags.options.tolerance_m), "--tolerance", "give meters, up to 10");
  if (flags.threads < 0 || flags.threads > 1024)
    throw Error("is not a number of threads", "--threads", "give 0 to 1024");
  const std::vector<ScoreLimit> limits = parse_limits(flags.limits, numbers_of({}), "'median<=0.01'");
  std::error_code ignored;
  const bool is_run = std::filesystem::is_directory(flags.estimate, ignored);
  const std::string file = is_run ? (std::filesystem::path(flags.estimate) / "cloud.ply").string() : flags.estimate;
  TaskPool pool(flags.threads);
  const CloudAgreement agreement =
      cloud_agreement(read_mesh_ply(flags.reference), read_cloud_ply(file), flags.options, &pool);
  if (flags.json) {
    fmt::print("{}", as_json(numbers_of(agreement)));
  } else if (!flags.quiet) {
    for (const auto& [name, value] : numbers_of(agreement))
      fmt::print("{:<15} {}\n", name, std::round(value * 1e5) / 1e5);
  }
  return report_missed(limits, numbers_of(agreement));
}

}  // namespace

void add_evaluate_cloud_command(CLI::App& evaluate, Context& context) {
  CLI::App* command =
      evaluate.add_subcommand("cloud", "Accuracy and completeness of a point cloud against true surfaces");
  const auto flags = std::make_shared<EvaluateCloudFlags>();
  command->add_option("REF", flags->reference, "PLY of the ground truth")->type_name("")->required();
  command->add_option("EST", flags->estimate, "PLY of the point cloud, or a run folder")->type_name("")->required();
  command
      ->add_option("--tolerance", flags->options.tolerance_m,
                   "Tolerance of precision and completeness in meters (default: 0.02)")
      ->type_name("M");
  command
      ->add_option("--require", flags->limits, "Limit, such as 'median<=0.01'; exit code 1 if missed; may be repeated")
      ->type_name("LIMIT")
      ->allow_extra_args(false);
  command
      ->add_option("--threads", flags->threads,
                   "Number of threads; the results do not depend on it (default: all cores)")
      ->type_name("N");
  command->add_flag("--json", flags->json, "Print the result as JSON");
  command->add_flag("--quiet", flags->quiet, "Print errors and warnings only");
  command->footer(evaluate_cloud_footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    context.exit_code = evaluate_cloud(*flags);
  });
}

}  // namespace rastro::cli
