// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/cli/benchmark/benchmark_list.h"
#include "rastro/cli/benchmark/benchmark_plan.h"
#include "rastro/cli/benchmark/benchmark_run.h"
#include "rastro/cli/benchmark/benchmark_session.h"
#include "rastro/cli/benchmark/benchmark_table.h"
#include "rastro/cli/command.h"
#include "rastro/synthetic/disturbance/disturbance.h"

namespace rastro::cli {
namespace {

struct BenchmarkFlags {
  std::string file, out, data, baseline, save, only;
  int jobs = 1;
  int threads = 0;
  bool force = false, dry_run = false, quiet = false;
};

constexpr const char* benchmark_footer = R"(
FILE is a YAML list of recordings or worlds, methods, settings and disturbances; docs/how-to/benchmark.md describes it, bench/lists has
some. Each run is a process of this program. Its result is one file in --out/results; interrupted with Ctrl-C, the same command goes on
where it was. Results of another program, of a list that says otherwise now, of other --jobs or --threads, or of files that changed
since are run again.

Columns, per entry over its seeds:
  runs               with a result, of those in the list if some are missing
  median m, worst m  absolute trajectory error (rmse) over the frames with a pose: SE3 where the run claims meters, Sim3 where not, in
                     their plane where all poses lie in one; of a laser log with relations their mean error; of localization in the
                     frame of the map, without an alignment
  tracked %          frames in state tracking, weak or relocalized
  false              of these, frames further off the ground truth than the limit (0.1 m); +N: of others that have a pose
  inside 95 %        mean share of the poses inside the ellipse that should hold 95 % of them, positions/rotations ('rastro evaluate
                     trajectory'); - without covariances
  warned             runs that said that something is wrong with input or result, or refused wrong input
  ms/frame, CPU ms   time of the whole process per frame, medians; CPU: over all threads
  MB                 largest resident memory
  (value)            that of --baseline where it differs
Exit code 1: an entry is worse than the baseline beyond the tolerance, or none could be compared.
)";

std::string disturbances_text() {
  std::string text = "\nDisturbances, also as --disturb of slam, odometry and localize:\n";
  for (const DisturbanceKind& kind : disturbance_kinds()) {
    const std::string name = kind.value.empty() ? kind.name : kind.name + "=" + kind.value;
    const std::string by_default = kind.default_value.empty() ? "" : fmt::format(" (default: {})", kind.default_value);
    text += fmt::format("  {:<22} {}{}\n", name, kind.summary, by_default);
  }
  return text;
}

constexpr const char* examples = R"(
Examples:
  rastro benchmark bench/lists/quick.yaml --out quick --save quick.json
  rastro benchmark bench/lists/quick.yaml --out quick_new --baseline quick.json
  rastro benchmark bench/lists/worlds.yaml --out worlds --jobs 2
  rastro benchmark bench/lists/wrong_inputs.yaml --out wrong --only kitti_00)";

BenchmarkList chosen_entries(const BenchmarkFlags& flags) {
  BenchmarkList list = read_benchmark_list(flags.file);
  const auto is_other = [&](const BenchmarkEntry& entry) { return entry.name.find(flags.only) == std::string::npos; };
  list.entries.erase(std::remove_if(list.entries.begin(), list.entries.end(), is_other), list.entries.end());
  if (list.entries.empty())
    throw Error("no entry has this in its name: " + flags.only, "--only", "--dry-run lists the entries");
  return list;
}

void print_plan(const BenchmarkPlan& plan) {
  for (const BenchmarkRun& run : plan.runs) fmt::print("{}\n  {}\n", run.id, plan.command_of(run));
}

int report(const BenchmarkFlags& flags, const BenchmarkList& list, const std::vector<BenchmarkResult>& results,
           const BenchmarkRows& baseline) {
  const BenchmarkRows rows = rows_of(list, results);
  fmt::print("{}{}{}", table_text(rows, baseline), warnings_text(rows), expectations_text(list, results));
  if (!flags.save.empty()) write_whole_file(flags.save, to_json(rows));
  if (flags.baseline.empty()) return done;
  const std::vector<std::string> worse = worse_than(rows, baseline, list.tolerance);
  for (const std::string& line : worse) fmt::print("worse: {}\n", line);
  const int compared = compared_with(rows, baseline);
  if (worse.empty())
    fmt::print("{} of {} entries compared{} {}\n", compared, rows.size(),
               compared > 0 ? ": nothing is worse than" : " with", flags.baseline);
  return worse.empty() && compared > 0 ? done : limit_missed;
}

/// Before hours of runs.
BenchmarkRows baseline_for(const BenchmarkList& list, const std::string& file) {
  BenchmarkRows baseline = read_benchmark_rows(file);
  const auto is_known = [&](const BenchmarkEntry& entry) {
    return std::any_of(baseline.begin(), baseline.end(),
                       [&](const BenchmarkRow& row) { return row.name == entry.name; });
  };
  if (std::none_of(list.entries.begin(), list.entries.end(), is_known))
    throw Error("has none of the entries that are run", file, "give the table of the same list, or omit --baseline");
  return baseline;
}

int benchmark(const BenchmarkFlags& flags) {
  const BenchmarkList list = chosen_entries(flags);
  const BenchmarkPlan plan = plan_benchmark(list, data_folder(flags.data));
  if (flags.dry_run) {
    print_plan(plan);
    return done;
  }
  const BenchmarkRows baseline = flags.baseline.empty() ? BenchmarkRows() : baseline_for(list, flags.baseline);
  const BenchmarkSetup setup = benchmark_setup({.out = flags.out,
                                                .jobs = flags.jobs,
                                                .threads = flags.threads,
                                                .force = flags.force,
                                                .timeout_s = list.timeout_s},
                                               list.keep);
  const ResumedBenchmark resumed = resume_benchmark(plan, setup);
  if (!flags.quiet) fmt::print(stderr, "{}\n", resumed.text());
  const auto results = run_missing(plan, resumed, setup, benchmark_tools(setup, flags.quiet));
  if (results.size() < plan.runs.size())
    fmt::print(stderr, "interrupted: {} of {} runs have results; the same command goes on\n", results.size(),
               plan.runs.size());
  return report(flags, list, results, baseline);
}

}  // namespace

void add_benchmark_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("benchmark", "Runs a list of recordings, worlds and methods and scores them");
  const auto flags = std::make_shared<BenchmarkFlags>();
  command->add_option("FILE", flags->file, "List of runs, YAML")->type_name("")->required();
  command->add_option("--out", flags->out, "Folder of the results; kept from call to call")->type_name("DIR");
  command
      ->add_option("--data", flags->data,
                   "Folder of the recordings in the list (default: $RASTRO_DATA, else ../shared/data)")
      ->type_name("DIR");
  command->add_option("--baseline", flags->baseline, "Compare with results saved before")->type_name("FILE");
  command->add_option("--save", flags->save, "Save the table for --baseline")->type_name("FILE");
  command->add_option("--only", flags->only, "Only entries with this text in their name")->type_name("TEXT");
  command->add_option("--jobs", flags->jobs, "Runs at the same time; times are best measured with 1")
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--threads", flags->threads, "Threads of each run (default: all cores divided by --jobs)")
      ->type_name("N");
  command->add_flag("--force", flags->force, "Run again what has a result");
  command->add_flag("--dry-run", flags->dry_run, "Print the runs of the list and their commands only");
  command->add_flag("--quiet", flags->quiet, "No line after each run");
  command->footer(benchmark_footer + disturbances_text() + examples);
  command->callback([flags, &context] { context.exit_code = benchmark(*flags); });
}

}  // namespace rastro::cli
