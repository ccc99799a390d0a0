// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/run_figures.h"

#include <gmock/gmock.h>

#include <cmath>

namespace rastro::cli {
namespace {

/// A frame each 0.1 s: t tracked, other letters not.
std::vector<RunFrame> frames_of(const std::string& states) {
  std::vector<RunFrame> frames;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const auto number = static_cast<std::int64_t>(k);
    frames.push_back({number, number * 100'000'000, states[k] == 't', states[k] == 't' ? "tracking" : "lost", "dark"});
  }
  return frames;
}

TEST(RunFigures, FramesGiveStartAndLosses) {
  RunFigures figures;
  add_frame_figures(frames_of("..ttt..t.tt...t"), figures);
  EXPECT_NEAR(figures.at("start_s"), 0.2, 1e-9);
  EXPECT_EQ(figures.at("losses"), 3.0);
  EXPECT_NEAR(figures.at("longest_loss_s"), 0.4, 1e-9) << "from the last tracked frame to the next";
  EXPECT_EQ(first_loss_of(frames_of("..tt.t")), "frame 4: dark");
  EXPECT_EQ(first_loss_of(frames_of("..tt")), "");
  RunFigures none;
  add_frame_figures(frames_of("...."), none);
  EXPECT_TRUE(none.empty());
}

TEST(RunFigures, StagesAreMeansOverAllFrames) {
  RunFigures figures;
  add_result_figures(nlohmann::ordered_json::parse(R"({"frames": 10, "ms_per_frame_mean": 20.0,
    "stages": {"keyframe": {"frames": 5, "ms_mean": 8.0}}})"),
                     figures);
  EXPECT_NEAR(figures.at("stage/keyframe_ms"), 4.0, 1e-9);
  EXPECT_NEAR(figures.at("frames_per_second"), 50.0, 1e-9);
}

TEST(RunFigures, TwoPosesHaveNoError) {
  Trajectory truth, estimate;
  for (int k = 0; k < 10; ++k) truth.push_back({k * 100'000'000LL, SE3(SO3(), {0.1 * k, std::sin(0.2 * k), 0.0})});
  const auto figures_of_poses = [&](int count) {
    estimate.clear();
    for (int k = 0; k < count; ++k) estimate.push_back({k * 100'000'000LL, SE3(SO3(), {9.0 * k, 0.0, 0.0})});
    const TrajectoryInput reference = trajectory_input_from(truth, "truth");
    RunFigures figures;
    add_trajectory_figures(score_trajectory(reference, trajectory_input_from(estimate, "estimate"), {}), reference,
                           false, figures);
    return figures;
  };
  const RunFigures of_two = figures_of_poses(2);
  EXPECT_EQ(of_two.size(), 1U);
  EXPECT_TRUE(of_two.contains("coverage_percent"));
  EXPECT_TRUE(figures_of_poses(3).contains("ate_m"));
}

/// Along a curve; the estimate is `first` times as large in the first half, `second` times in the second.
TrajectoryScores scores_with(double first, double second, TrajectoryInput& reference) {
  Trajectory truth, estimate;
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector3d p(0.1 * k, std::sin(0.2 * k), 0.01 * k * k);
    truth.push_back({k * 100'000'000LL, SE3(SO3(), p)});
    estimate.push_back({k * 100'000'000LL, SE3(SO3(), (k < 20 ? first : second) * p)});
  }
  reference = trajectory_input_from(truth, "truth");
  return score_trajectory(reference, trajectory_input_from(estimate, "estimate"), {});
}

TEST(RunFigures, ScaleErrorAndItsDrift) {
  TrajectoryInput reference;
  RunFigures figures, of_one_camera;
  const TrajectoryScores long_by_a_tenth = scores_with(1.1, 1.1, reference);
  add_trajectory_figures(long_by_a_tenth, reference, true, figures);
  EXPECT_NEAR(figures.at("scale_error_percent"), 10.0, 1e-6);
  EXPECT_NEAR(figures.at("scale_drift_percent"), 0.0, 1e-6);
  const TrajectoryScores drifting = scores_with(1.0, 0.8, reference);
  add_trajectory_figures(drifting, reference, false, of_one_camera);
  EXPECT_NEAR(of_one_camera.at("scale_drift_percent"), 25.0, 1e-6)
      << "the second half is 1.25 times as large as it says";
  EXPECT_FALSE(of_one_camera.contains("scale_error_percent"));
}

}  // namespace
}  // namespace rastro::cli
