// SPDX-License-Identifier: Apache-2.0
// Every setting of the optical flow reaches it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "rastro/track/tracker.h"

namespace rastro {
namespace {

constexpr double step_px = 2.4;

/// Waves that move to the right; finer ones change from frame to frame.
GrayImage changing_waves(int k, double change) {
  GrayImage image(320, 240);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double u = x - step_px * k;
      const double value = 128.0 + 45.0 * std::sin(0.21 * u + 0.05 * y) + 40.0 * std::sin(0.17 * y - 0.08 * u) +
                           change * std::sin(0.9 * x + 0.7 * y + 1.3 * k);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(value));
    }
  }
  return image;
}

/// The features followed into the second frame, and the mean error of their motion, pixels.
std::pair<int, double> followed_with(const TrackOptions& options, double change) {
  Tracker tracker(options);
  const TrackFrame first = tracker.process(changing_waves(0, change).view(), 0);
  const TrackFrame second = tracker.process(changing_waves(1, change).view(), 1);
  double error = 0.0;
  for (const TrackedFeature& feature : second.features) {
    if (feature.state != TrackState::tracked) continue;
    const auto before = std::find_if(first.features.begin(), first.features.end(),
                                     [&](const TrackedFeature& other) { return other.id == feature.id; });
    const Eigen::Vector2f moved = feature.pixel - before->pixel;
    error += static_cast<double>((moved - Eigen::Vector2f(static_cast<float>(step_px), 0.0F)).norm()) /
             std::max(1, second.tracked);
  }
  return {second.tracked, error};
}

TrackOptions plain_flow() {
  TrackOptions options;
  options.mode = "klt";
  options.min_distance_px = 12;
  return options;
}

TEST(Tracker, StricterChecksOfTheFlowLoseFeatures) {
  const auto [usual, usual_error] = followed_with(plain_flow(), 6.0);
  ASSERT_GT(usual, 50);
  EXPECT_LT(usual_error, 0.3);
  TrackOptions options = plain_flow();
  options.max_backward_px = 0.01;
  EXPECT_LT(followed_with(options, 6.0).first, usual * 4 / 5);
  options = plain_flow();
  options.max_residual_ratio = 0.01;
  EXPECT_LT(followed_with(options, 6.0).first, usual * 4 / 5);
  options = plain_flow();
  options.min_texture = 1e4;
  EXPECT_EQ(followed_with(options, 6.0).first, 0);
}

TEST(Tracker, EverySettingOfTheStepsOfTheFlowReachesIt) {
  TrackOptions options = plain_flow();
  options.max_backward_px = 3.0;
  options.max_residual_ratio = 1.0;
  const auto error_with = [&](auto TrackOptions::*setting, auto value) {
    TrackOptions changed = options;
    changed.*setting = value;
    return followed_with(changed, 6.0).second;
  };
  const double usual = followed_with(options, 6.0).second;
  EXPECT_NE(error_with(&TrackOptions::flow_iterations, 1), usual);
  EXPECT_NE(error_with(&TrackOptions::flow_epsilon_px, 1.0), usual);
  EXPECT_NE(error_with(&TrackOptions::flow_coarse_epsilon_px, 1.0), usual);
  EXPECT_GT(error_with(&TrackOptions::flow_window_px, 5), 1.3 * usual) << "a small window has more of what changes";
}

/// "The paper's own steps" of docs/benchmarks.md, and nothing else.
TEST(TrackOptions, ThePaperPresetSetsThePapersStepsAndLeavesTheRest) {
  const std::map<std::string, std::string> paper = {{"predict", "false"},
                                                    {"candidates_factor", "1"},
                                                    {"candidates_distance_px", "0"},
                                                    {"verify_corners", "false"},
                                                    {"align", "false"},
                                                    {"min_inlier_share", "0"},
                                                    {"max_travel_px", "0"},
                                                    {"max_reference_residual", "0"},
                                                    {"max_residual_ratio", "100"},
                                                    {"max_reprojection_px", "3"},
                                                    {"max_epipolar_error_px", "1"},
                                                    {"ransac_iterations", "200"}};
  TrackOptions options;
  const OptionTable table = option_table(options);
  set_paper_preset(options);
  std::map<std::string, std::string> changed;
  for (std::size_t i = 0; i < table.options().size(); ++i)
    if (table.value_of(i) != table.default_of(i)) changed[table.options()[i].name] = table.value_of(i);
  EXPECT_EQ(changed, paper);
  EXPECT_EQ(options.features, 150);
  EXPECT_EQ(options.window, 30);
}

}  // namespace
}  // namespace rastro
