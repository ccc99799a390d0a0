// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/compare_plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"

namespace rastro::cli {
namespace {

std::string name_of(const CompareInput& input, const CompareRun& run) {
  std::string name = fmt::format("{} {}", input.name, run.column);
  if (run.repeat > 1) name += fmt::format(" repeat {}", run.repeat);
  if (run.again) name += " again";
  return name;
}

BenchmarkEntry entry_of(const CompareInput& input, const MethodOffer& method, const CompareRun& run) {
  BenchmarkEntry entry;
  entry.name = name_of(input, run);
  entry.input = input.input;
  entry.seeds = input.seeds;
  entry.has_ground_truth = input.facts.has_ground_truth;
  entry.method.command = method.command;
  entry.method.method = method.method;
  if (method.as_scan()) {
    entry.input.as_scan = true;
    entry.input.camera_flags = input.flags;
    entry.alignment = "se3";  // the plane of the scans is not that of the camera's axes
  } else {
    entry.method.sensor = method.sensor;
    entry.method.flags = input.flags;
  }
  if (run.repeat > 1) entry.method.flags.insert(entry.method.flags.end(), {"--seed", fmt::format("{}", run.repeat)});
  return entry;
}

void add(const CompareInput& input, const MethodOffer& method, const CompareRun& run, ComparePlan& plan) {
  plan.list.entries.push_back(entry_of(input, method, run));
  plan.runs.push_back(run);
}

}  // namespace

void plan_methods(const CompareInput& input, std::size_t index, const std::vector<MethodOffer>& methods, int repeats,
                  ComparePlan& plan) {
  for (const MethodOffer& method : methods) {
    const int seeds = method.has_seed ? repeats : 1;
    for (int repeat = 1; repeat <= seeds; ++repeat) add(input, method, {index, method.name(), repeat, false, ""}, plan);
    if (repeats > 1) add(input, method, {index, method.name(), 1, true, ""}, plan);
  }
}

void plan_disturbed(std::size_t index, const std::string& method, const std::string& disturbance, ComparePlan& plan) {
  const auto is_plain = [&](const CompareRun& run) {
    return run.input == index && run.column == method && run.repeat == 1 && !run.again && run.disturbance.empty();
  };
  const auto plain = std::find_if(plan.runs.begin(), plan.runs.end(), is_plain);
  RASTRO_CHECK(plain != plan.runs.end(), "only a planned run can be disturbed");
  BenchmarkEntry entry = plan.list.entries[static_cast<std::size_t>(plain - plan.runs.begin())];
  entry.name += " " + disturbance;
  if (!entry.seeds.empty()) entry.seeds = {entry.seeds.front()};
  entry.disturbances = {disturbance};
  plan.list.entries.push_back(std::move(entry));
  plan.runs.push_back({index, method, 1, false, disturbance});
}

}  // namespace rastro::cli
