// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/strengths.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/cli/benchmark/run_frames.h"

namespace rastro::cli {
namespace {

constexpr double least_completion_ratio = 0.9, most_error_ratio = 2.0;
constexpr double least_error_m = 0.001;  ///< Smaller errors count as this.

/// A method that is still on its way up, beside its run without a disturbance.
struct Climber {
  const StrengthLadder* ladder = nullptr;
  MethodOffer method;
  FinishedRun without;
  std::vector<RunFrame> frames;  ///< Of the run without.
  std::int64_t middle = 0;
  StrengthCurve curve;
};

struct Share {
  double tracked = 0.0, frames = 0.0;
  double value() const { return frames > 0.0 ? tracked / frames : 0.0; }
};

/// Of the frames but [middle, middle + covered).
Share tracked_share(const std::vector<RunFrame>& frames, std::int64_t middle, double covered) {
  Share share;
  for (const RunFrame& frame : frames) {
    if (frame.frame >= middle && static_cast<double>(frame.frame - middle) < covered) continue;
    share.frames += 1.0;
    share.tracked += frame.tracked ? 1.0 : 0.0;
  }
  return share;
}

std::optional<double> recovery_of(const std::vector<RunFrame>& frames, std::int64_t middle, double covered) {
  std::optional<TimeNs> begin;
  for (const RunFrame& frame : frames) {
    if (frame.frame < middle || static_cast<double>(frame.frame - middle) < covered) continue;
    if (!begin) begin = frame.stamp;
    if (frame.tracked) return to_seconds(frame.stamp - *begin);
  }
  return std::nullopt;
}

std::string verdict_of(const StrengthStep& step) {
  if (step.completion_ratio && *step.completion_ratio < least_completion_ratio) return "loses track";
  if (step.error_ratio && *step.error_ratio > most_error_ratio) return "doubles its error";
  return "";
}

StrengthStep step_of(const Climber& climber, double strength, const FinishedRun& run) {
  StrengthStep step;
  step.strength = strength;
  step.assignment = run.what.disturbance;
  step.command = run.run_command;
  step.warned = run.result.scores.warned;
  step.failure = run.result.failure;
  if (!step.failure.empty()) return step;
  if (run.result.scores.frames == 0) {
    step.failure = "refuses the input";
    return step;
  }
  const double covered = climber.ladder->is_range ? strength : 0.0;
  const auto frames = read_run_frames(run.folder / "stats.csv");
  const double share = tracked_share(frames, climber.middle, covered).value();
  const double share_without = tracked_share(climber.frames, climber.middle, covered).value();
  step.completion_ratio = share_without > 0.0 ? share / share_without : 1.0;
  if (covered > 0.0) step.recovery_s = recovery_of(frames, climber.middle, covered);
  const auto &error = run.result.scores.ate_m, &error_without = climber.without.result.scores.ate_m;
  if (error && error_without) step.error_ratio = *error / std::max(least_error_m, *error_without);
  step.failure = verdict_of(step);
  return step;
}

/// Every method that tracks something on an input of images, on every ladder; not where the input is wrong already.
std::vector<Climber> climbers_of(const std::vector<StrengthLadder>& ladders, const CompareSession& session) {
  std::vector<Climber> climbers;
  const Comparison comparison = session.comparison();
  for (const FinishedRun& run : comparison.runs) {
    const bool is_first = run.seed == 0 || run.seed == comparison.inputs[run.what.input].seeds.front();
    if (!run.is_plain() || run.what.repeat != 1 || !is_first || run.failed() || run.result.scores.tracked == 0)
      continue;
    const CompareInput& input = comparison.inputs[run.what.input];
    if (!input.facts.has_image || input.is_special) continue;
    const auto& methods = session.methods_on(run.what.input);
    const auto method = std::find_if(methods.begin(), methods.end(),
                                     [&](const MethodOffer& each) { return each.name() == run.what.column; });
    if (method == methods.end() || method->as_scan()) continue;
    const auto frames = read_run_frames(run.folder / "stats.csv");
    for (const StrengthLadder& ladder : ladders)
      climbers.push_back({&ladder,
                          *method,
                          run,
                          frames,
                          frames[frames.size() / 2].frame,
                          {run.what.input, run.what.column, ladder.name, {}}});
  }
  return climbers;
}

/// A covered part leaves enough frames behind it to see whether tracking goes on.
bool fits_into(const Climber& climber, double strength) {
  constexpr std::int64_t fewest_behind = 10;
  return !climber.ladder->is_range ||
         climber.middle + static_cast<std::int64_t>(strength) + fewest_behind <= climber.frames.back().frame + 1;
}

bool is_climbing(const Climber& climber, std::size_t rung) {
  return rung < climber.ladder->strengths.size() && climber.curve.steps.size() == rung &&
         climber.curve.failure() == nullptr && fits_into(climber, climber.ladder->strengths[rung]);
}

void add_steps(const CompareSession& session, std::size_t rung, std::vector<Climber>& climbers) {
  const Comparison comparison = session.comparison();
  for (Climber& climber : climbers) {
    if (!is_climbing(climber, rung)) continue;
    const double strength = climber.ladder->strengths[rung];
    const std::string assignment = assignment_of(*climber.ladder, strength, climber.middle);
    const auto run = std::find_if(comparison.runs.begin(), comparison.runs.end(), [&](const FinishedRun& each) {
      return each.what.disturbance == assignment && each.what.input == climber.curve.input &&
             each.what.column == climber.curve.column;
    });
    if (run != comparison.runs.end()) climber.curve.steps.push_back(step_of(climber, strength, *run));
  }
}

}  // namespace

const std::vector<StrengthLadder>& strength_ladders() {
  static const std::vector<StrengthLadder> ladders = {
      {"noise", "noise", "sigma of 255", "noise", false, {10, 20, 40, 80}},
      {"dark", "low light", "times darker", "dark", false, {4, 8, 16, 32, 64}},
      {"blur", "motion blur", "pixels", "blur", false, {4, 8, 16, 32}},
      {"crowd", "people walking by", "share of the image", "crowd", false, {0.1, 0.2, 0.4, 0.6}},
      {"covered", "covered camera", "frames", "black", true, {5, 15, 45}},
      {"abrupt", "abrupt motion: missing frames", "frames", "drop", true, {2, 4, 8, 16, 32}},
      {"focal", "wrong focal length", "factor", "focal-length", false, {0.98, 0.95, 0.9, 0.8, 0.6}}};
  return ladders;
}

std::vector<StrengthLadder> ladders_named(const std::vector<std::string>& names) {
  std::vector<StrengthLadder> chosen;
  std::vector<std::string> known;
  for (const StrengthLadder& ladder : strength_ladders()) known.push_back(ladder.name);
  for (const std::string& name : names) {
    if (name == "default") return strength_ladders();
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end())
      throw Error(in_quotes(name) + " has no strengths", "--disturb", did_you_mean(name, known));
    chosen.push_back(strength_ladders()[static_cast<std::size_t>(found - known.begin())]);
  }
  return chosen;
}

std::string assignment_of(const StrengthLadder& ladder, double strength, std::int64_t middle) {
  if (!ladder.is_range) return fmt::format("{}={:g}", ladder.kind, strength);
  return fmt::format("{}={}:{}", ladder.kind, middle, middle + static_cast<std::int64_t>(strength));
}

bool climb_ladders(const std::vector<StrengthLadder>& ladders, CompareSession& session,
                   std::vector<StrengthCurve>& curves) {
  std::vector<Climber> climbers = climbers_of(ladders, session);
  bool complete = true;
  for (std::size_t rung = 0; complete; ++rung) {
    bool any = false;
    for (const Climber& climber : climbers) {
      if (!is_climbing(climber, rung)) continue;
      any = true;
      const std::string assignment = assignment_of(*climber.ladder, climber.ladder->strengths[rung], climber.middle);
      session.add_disturbed(climber.curve.input, climber.method, assignment);
    }
    if (!any) break;
    complete = session.run();
    add_steps(session, rung, climbers);
  }
  for (Climber& climber : climbers) curves.push_back(std::move(climber.curve));
  return complete;
}

}  // namespace rastro::cli
