// SPDX-License-Identifier: Apache-2.0
// Every method on every recording it is made for, against the limits of tests/golden/accuracy.csv.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "accuracy_input.h"
#include "rastro/evaluate/trajectory_scores.h"
#include "rastro/methods/methods.h"

namespace rastro {
namespace {

struct AccuracyResult {
  std::int64_t frames = 0;
  Trajectory trajectory;  ///< In the order of time.
};

bool is_odometry(const std::string& method) {
  const auto methods = odometry_methods();
  return method != "rgbd" &&
         std::any_of(methods.begin(), methods.end(), [&](const auto& each) { return each->name() == method; });
}

/// The only place that knows how an odometry is made.
std::unique_ptr<Odometry> make_odometry(const std::string& method, const SourceInfo& info, TaskPool& pool) {
  return odometry_method(method)->make(info, {.pool = &pool});
}

std::unique_ptr<Slam> make_slam(const AccuracyRow& row, const SourceInfo& info, TaskPool& pool) {
  const auto method = slam_method(row.method);
  OptionTable table = method->options();
  for (const Option& option : table.options()) {
    if (option.name == "sensor") table.set("sensor", row.sensor, "accuracy.csv");
  }
  return method->make(info, {.pool = &pool});
}

AccuracyResult run_odometry(const std::string& method, Source& source, TaskPool& pool) {
  AccuracyResult result;
  const auto odometry = make_odometry(method, source.info(), pool);
  while (const auto frame = source.next()) {
    odometry->process(*frame);
    ++result.frames;
  }
  result.trajectory = odometry->trajectory();
  return result;
}

AccuracyResult run_slam(const AccuracyRow& row, Source& source, TaskPool& pool) {
  AccuracyResult result;
  const auto slam = make_slam(row, source.info(), pool);
  while (const auto frame = source.next()) {
    slam->process(*frame);
    ++result.frames;
  }
  slam->finish();
  result.trajectory = slam->trajectory();
  return result;
}

/// "rgbd" names an odometry and a SLAM method; the odometry is written as "rgbd-odometry".
AccuracyResult run_row(const AccuracyRow& row, Source& source) {
  TaskPool pool(1);
  AccuracyResult result;
  if (row.method == "rgbd-odometry" || is_odometry(row.method))
    result = run_odometry(row.method == "rgbd-odometry" ? "rgbd" : row.method, source, pool);
  else
    result = run_slam(row, source, pool);
  std::stable_sort(result.trajectory.begin(), result.trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  return result;
}

double error_of(const AccuracyRow& row, const AccuracyInput& input, const Trajectory& trajectory) {
  if (row.alignment == "relations") {
    const RelationScores scores = score_relations(input.relations, trajectory, 0);
    EXPECT_GT(scores.relations, 100) << "of the relations within these scans";
    return scores.trans_mean_m;
  }
  TrajectoryScoreOptions options;
  options.alignment = parse_alignment(row.alignment);
  const TrajectoryScores scores = score_trajectory(trajectory_input_from(input.ground_truth, "truth"),
                                                   trajectory_input_from(trajectory, "estimate"), options);
  EXPECT_GE(scores.pairing.matched * 10, static_cast<int>(trajectory.size()) * 9) << "poses without truth say nothing";
  return scores.ate_m.value().rmse;
}

/// Limits hold for the release build: another compiler rounds differently, so that other matches are drawn.
#ifdef RASTRO_SANITIZED
constexpr double limit_share = 1.5;
#else
constexpr double limit_share = 1.0;
#endif

class Accuracy : public testing::TestWithParam<AccuracyRow> {};

TEST_P(Accuracy, StaysWithinItsLimit) {
  const AccuracyRow& row = GetParam();
  if (!row.is_generated() && !std::filesystem::exists(recorded_file(row)))
    GTEST_SKIP() << "no recorded data at " << recorded_file(row) << " (set RASTRO_DATA)";
  AccuracyInput input = open_input(row);
  const AccuracyResult result = run_row(row, *input.source);
  ASSERT_FALSE(result.trajectory.empty());
  EXPECT_EQ(result.frames, row.end - row.first) << "the recording has another length than its row says";
  const double coverage = 100.0 * static_cast<double>(result.trajectory.size()) / static_cast<double>(result.frames);
  const double error_m = error_of(row, input, result.trajectory);
  RecordProperty("error_m", fmt::format("{:.4f}", error_m));
  RecordProperty("coverage_pct", fmt::format("{:.1f}", coverage));
  fmt::print("{}: error {:.4f} m (limit {:.4f}), coverage {:.1f} %\n", row.name(), error_m, row.limit_m, coverage);
  EXPECT_LE(error_m, limit_share * row.limit_m) << "measured before: " << row.measured_m << " m; " << row.why;
  EXPECT_GE(coverage, row.coverage_pct) << row.why;
}

INSTANTIATE_TEST_SUITE_P(Golden, Accuracy, testing::ValuesIn(read_accuracy_rows(RASTRO_ACCURACY_ROWS)),
                         [](const auto& parameter) { return parameter.param.name(); });

/// A limit far above the measured error is useless: see the rule at the top of the file.
TEST(AccuracyRows, LimitsFollowTheirRule) {
  for (const AccuracyRow& row : read_accuracy_rows(RASTRO_ACCURACY_ROWS)) {
    const double rule = 1.15 * row.measured_m + 0.001;
    const bool chaotic = row.why.find("chaotic") != std::string::npos;
    EXPECT_LE(row.limit_m, (chaotic ? 2.0 : 1.0) * rule + 1e-4) << row.name();
    EXPECT_GT(row.limit_m, row.measured_m) << row.name();
    EXPECT_GT(row.coverage_pct, 0.0) << row.name();
  }
}

}  // namespace
}  // namespace rastro
