// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/comparison.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "rastro/base/text.h"
#include "rastro/cli/compare/map_figures.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

std::string as_typed(const std::vector<std::string>& words, const fs::path& out) {
  std::string line = "rastro";
  for (const std::string& word : words) line += " " + as_shell_word(resolved(word, out));
  return line;
}

FinishedRun finished(const CompareRun& what, const BenchmarkRun& run, const BenchmarkResult& result,
                     const BenchmarkSetup& setup) {
  FinishedRun done;
  done.what = what;
  done.seed = run.seed;
  done.result = result;
  done.folder = setup.out / "runs" / run.id;
  done.recording = resolved(run.words[1], setup.out);
  done.ground_truth = resolved(run.judgment.ground_truth, setup.out);
  done.run_command = as_typed(run.words, setup.out) + " --force --out " + as_shell_word(done.folder.string());
  if (setup.threads > 0) done.run_command += fmt::format(" --threads {}", setup.threads);
  const std::string& alignment = result.scores.alignment;
  if (!alignment.empty())
    done.evaluate_command = fmt::format("rastro evaluate trajectory {} {} --align {}", as_shell_word(done.ground_truth),
                                        as_shell_word(done.folder.string()), alignment);
  return done;
}

using RunFiguresByName = std::map<std::string, double>;

double per_frame(double value, const RunScores& scores) {
  return scores.frames > 0 ? value / static_cast<double>(scores.frames) : 0.0;
}

/// The figures of a run by the names of compare_figures().
RunFiguresByName figures_of(const FinishedRun& run) {
  const RunScores& scores = run.result.scores;
  if (run.failed() || scores.frames == 0) return {{"completion_percent", 0.0}};
  RunFiguresByName figures = scores.figures;
  figures["completion_percent"] = 100.0 * per_frame(static_cast<double>(scores.tracked), scores);
  figures["cpu_ms"] = 1e3 * per_frame(run.result.cpu_s, scores);
  figures["memory_mb"] = run.result.peak_memory_mb;
  if (scores.ate_m) {
    figures["ate_m"] = *scores.ate_m;
    figures["false_percent"] =
        100.0 * per_frame(static_cast<double>(scores.false_poses + scores.false_poses_lost), scores);
  }
  if (scores.inside_position_percent) figures["inside_position_percent"] = *scores.inside_position_percent;
  return figures;
}

bool is_error(const std::string& figure) {
  return figure.starts_with("ate") || figure.starts_with("rpe") || figure.starts_with("drift") ||
         figure.starts_with("scale") || figure.starts_with("coverage") || figure.starts_with("inside") ||
         figure.starts_with("false");
}

/// A map of one camera is made metric first, in a copy, and one length more exactly so.
std::string measure_command(const std::string& folder, const FinishedRun& run) {
  const std::string known =
      run.result.scores.alignment == "sim3" ? known_length_of_mono_maps(run.recording) : std::string();
  const std::string objects = as_shell_word(run.recording + "/objects.yaml"), is = as_shell_word(folder);
  if (known.empty()) return fmt::format("rastro measure {} --objects {}", is, objects);
  return fmt::format(
      "cp -r {0} {1} && rastro scale {1} --reference {2} && rastro measure {1} --objects {3} --known {4}", is,
      as_shell_word(folder + "_metric"), as_shell_word(run.recording), objects, as_shell_word(known));
}

/// What prints the figure, or of times and counts the run itself, whose result.json has them.
std::string command_of(const std::string& figure, const FinishedRun& run) {
  const std::string folder = run.folder.string();
  if (figure.starts_with("surface"))
    return fmt::format("rastro export {0} --to ply --out {1} && rastro evaluate cloud {2} {1}", as_shell_word(folder),
                       as_shell_word(folder + "/surface.ply"), as_shell_word(run.recording + "/truth.ply"));
  if (figure.starts_with("length")) return measure_command(folder, run);
  return is_error(figure) ? run.evaluate_command : run.run_command;
}

void add_figures(const CompareInput& input, const FinishedRun& run, ResultTable& table) {
  for (const auto& [figure, value] : figures_of(run)) {
    const std::string command = command_of(figure, run);
    table.add(input.name, run.what.column, figure, {value, run.seed, run.what.repeat, command});
  }
}

/// Compares the run with the first repeat of the same seed.
void add_same_bytes(const CompareInput& input, const FinishedRun& again, const std::vector<FinishedRun>& runs,
                    ResultTable& table) {
  const auto first = std::find_if(runs.begin(), runs.end(), [&](const FinishedRun& run) {
    return run.is_plain() && run.what.input == again.what.input && run.what.column == again.what.column &&
           run.what.repeat == 1 && run.seed == again.seed;
  });
  if (first == runs.end() || first->failed() || again.failed()) return;
  const bool same = first->result.scores.sha256 == again.result.scores.sha256;
  table.add(input.name, again.what.column, "same_bytes_percent",
            {same ? 100.0 : 0.0, again.seed, 1, again.run_command});
}

}  // namespace

int runs_at_once(const Comparison& comparison) {
  int most = 1;
  for (const FinishedRun& run : comparison.runs) most = std::max(most, run.result.jobs);
  return most;
}

std::string interruption_text(const Comparison& comparison) {
  if (comparison.runs.size() >= comparison.planned) return "";
  return fmt::format("interrupted: {} of {} runs have results", comparison.runs.size(), comparison.planned);
}

std::vector<FinishedRun> finished_runs(const ComparePlan& planned, const BenchmarkPlan& plan,
                                       const std::vector<BenchmarkResult>& results, const BenchmarkSetup& setup) {
  std::map<std::pair<std::string, std::uint64_t>, const BenchmarkResult*> by_run;
  for (const BenchmarkResult& result : results) by_run[{result.entry, result.seed}] = &result;
  std::map<std::string, std::vector<const BenchmarkRun*>> by_entry;
  for (const BenchmarkRun& run : plan.runs) by_entry[run.entry].push_back(&run);
  std::vector<FinishedRun> done;
  for (std::size_t k = 0; k < planned.runs.size(); ++k) {
    for (const BenchmarkRun* run : by_entry[planned.list.entries[k].name]) {
      const auto result = by_run.find({run->entry, run->seed});
      if (result != by_run.end()) done.push_back(finished(planned.runs[k], *run, *result->second, setup));
    }
  }
  return done;
}

ResultTable table_of(const std::vector<CompareInput>& inputs, const std::vector<FinishedRun>& runs) {
  ResultTable table;
  for (const CompareInput& input : inputs) table.add_input(input.name);
  for (const FinishedRun& run : runs) {
    const CompareInput& input = inputs[run.what.input];
    if (run.is_plain()) add_figures(input, run, table);
    if (run.what.again) add_same_bytes(input, run, runs, table);
  }
  return table;
}

}  // namespace rastro::cli
