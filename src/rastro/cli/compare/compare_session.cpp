// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/compare_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/cli/benchmark/benchmark_parts.h"
#include "rastro/cli/common_flags.h"
#include "rastro/cli/compare/compare_list.h"
#include "rastro/cli/compare/paper_tables.h"
#include "rastro/cli/interrupt.h"

namespace rastro::cli {
namespace {

/// A plan with one run on the input, for its recording.
BenchmarkPlan plan_of_one(const CompareInput& input, const std::string& data_folder) {
  BenchmarkEntry entry;
  entry.name = input.name;
  entry.input = input.input;
  if (!input.seeds.empty()) entry.seeds = {input.seeds.front()};
  BenchmarkList list;
  list.entries = {entry};
  return plan_benchmark(list, data_folder);
}

double rate_of(Source& source) {
  const auto first = source.next();
  const auto second = first ? source.next() : std::nullopt;
  return second && second->stamp > first->stamp ? 1.0 / to_seconds(second->stamp - first->stamp) : 0.0;
}

InputFacts facts_of_recording(const std::string& path, OpenOptions options, const std::string& frames) {
  set_frames(frames, options);
  options.want_color = options.want_depth = options.want_right = false;
  options.read_ahead = 0;
  const auto source = rastro::open(path, options);
  InputFacts facts;
  try {
    facts = facts_of(source->info(), span_of_recording(path, options));
    facts.rate_hz = rate_of(*source);
  } catch (const Error&) {
    facts = facts_of(source->info(), {});  // the runs say what is wrong with the first frames
  }
  if (facts.frames > 0) {
    const std::int64_t chosen = std::min(options.end_frame, facts.frames) - options.first_frame;
    facts.frames = std::max<std::int64_t>(0, (chosen + options.every - 1) / options.every);
  }
  return facts;
}

}  // namespace

CompareSession::CompareSession(CompareTask task, BenchmarkSetup setup, BenchmarkTools tools, std::string data_folder)
    : task_(std::move(task)),
      setup_(std::move(setup)),
      forced_(setup_.force),
      tools_(std::move(tools)),
      data_folder_(std::move(data_folder)) {
  if (task_.list)
    plan_listed();
  else
    plan_all_methods();
}

std::string CompareSession::look_at(CompareInput& input) {
  std::string path = recording_of(input);
  input.facts = facts_of_recording(
      path, open_options_of(path, input.is_world() ? std::vector<std::string>() : input.flags), input.frames());
  recordings_.push_back(path);
  return path;
}

void CompareSession::plan_all_methods() {
  for (std::size_t k = 0; k < task_.inputs.size(); ++k) {
    CompareInput& input = task_.inputs[k];
    const std::string path = look_at(input);
    const std::vector<MethodOffer> wanted = task_.paper ? methods_named(paper_methods(input.facts)) : task_.methods;
    const MethodOffers offers = offers_for(path, open_options_of(path, input.flags), wanted);
    for (const std::string& refused : offers.refused) refused_.push_back(input.name + ": " + refused);
    for (const MethodOffer& method : offers.possible) column_kinds_[method.name()] = method.kind;
    offered_.push_back(offers.possible);
    plan_methods(input, k, offers.possible, task_.repeats, plan_);
  }
  if (std::any_of(offered_.begin(), offered_.end(), [](const auto& offers) { return !offers.empty(); })) return;
  throw Error(
      refused_.empty() ? "allows none of the methods" : "allows none of the methods (" + refused_.front() + ")",
      task_.inputs.front().name,
      task_.paper ? "give a recording of a camera, or --methods all" : "give --methods all to see what it allows");
}

void CompareSession::plan_listed() {
  ListedCells cells = cells_of(*task_.list);
  task_.inputs = cells.inputs;
  for (CompareInput& input : task_.inputs) look_at(input);
  choose_sensors(*task_.list, task_.inputs, cells);
  offered_.resize(task_.inputs.size());
  for (const ListedCell& cell : cells.cells) {
    column_kinds_[cell.column] = cell.method.kind;
    if (cell.column == cell.method.name()) offered_[cell.input].push_back(cell.method);
  }
  plan_list(*task_.list, cells, task_.inputs, task_.repeats, plan_);
}

std::string CompareSession::recording_of(const CompareInput& input) const {
  const BenchmarkPlan plan = plan_of_one(input, data_folder_);
  const BenchmarkRun& run = plan.runs.front();
  if (input.is_world()) {
    BenchmarkParts parts(plan, {&run}, setup_.out, setup_.program, true, tools_.run);
    const std::string failure = parts.need(run);
    stop_if_interrupted();
    if (!failure.empty()) throw Error(failure, input.name, "correct the flags of this world");
  }
  return resolved(run.words[1], setup_.out);
}

std::string CompareSession::plan_text() const {
  const BenchmarkPlan plan = plan_benchmark(plan_.list, data_folder_);
  std::string text;
  for (const BenchmarkRun& run : plan.runs) text += fmt::format("{}\n  {}\n", run.id, plan.command_of(run));
  return text;
}

std::vector<std::string> CompareSession::columns() const {
  std::vector<std::string> columns;
  for (const CompareRun& run : plan_.runs) columns.push_back(run.column);
  return columns;
}

void CompareSession::add_disturbed(std::size_t input, const MethodOffer& method, const std::string& disturbance) {
  plan_disturbed(input, method.name(), disturbance, plan_);
  if (!forced_) return;
  BenchmarkList added;
  added.entries = {plan_.list.entries.back()};
  forget_results(plan_benchmark(added, data_folder_), setup_);
}

bool CompareSession::run() {
  const BenchmarkPlan plan = plan_benchmark(plan_.list, data_folder_);
  const ResumedBenchmark resumed = resume_benchmark(plan, setup_);
  if (!task_.quiet) fmt::print(stderr, "{}\n", resumed.text());
  results_ = run_missing(plan, resumed, setup_, tools_);
  setup_.force = false;  // later calls go on with these, but for what is added
  return results_.size() == plan.runs.size();
}

Comparison CompareSession::comparison() const {
  const BenchmarkPlan plan = plan_benchmark(plan_.list, data_folder_);
  Comparison all;
  all.inputs = task_.inputs;
  all.refused = refused_;
  all.runs = finished_runs(plan_, plan, results_, setup_);
  all.planned = plan.runs.size();
  all.column_kinds = column_kinds_;
  all.table = table_of(all.inputs, all.runs);
  return all;
}

}  // namespace rastro::cli
