// SPDX-License-Identifier: Apache-2.0
// How the damping of bundle adjustment follows its success.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "rastro/optimize/bundle_normal.h"
#include "rastro/optimize/bundle_testing.h"

namespace rastro {
namespace {

using testing::bundle_scene;

double cost_of_bundle(Bundle bundle, BundleOptions options) {
  options.iterations = 0;
  return adjust_bundle(bundle, options).last_cost;
}

Bundle stepped(const Bundle& bundle, const BundleNormal& normal, const BundleStep& step) {
  Bundle moved = bundle;
  for (std::size_t i = 0; i < bundle.fixed.size(); ++i) {
    const int index = normal.free_index(i);
    if (index < 0) continue;
    const SO3 rotation = SO3::exp(step.cameras.segment<3>(6 * index + 3));
    const SE3& before = bundle.camera_from_world[i];
    moved.camera_from_world[i] =
        SE3(rotation * before.rotation(), rotation * before.translation() + step.cameras.segment<3>(6 * index).eval());
  }
  for (std::size_t i = 0; i < bundle.points.size(); ++i) moved.points[i] += step.points[i];
  return moved;
}

/// After a step that lowers the cost a tenth; after the first that does not ten times, after the second in a row
/// twenty times, then forty, and so on.
struct Schedule {
  double damping = 1e-5, growth = 10.0;
  int most_in_a_row = 0, in_a_row = 0;
  void succeed() {
    damping = std::max(1e-9, damping / 10.0);
    growth = 10.0;
    in_a_row = 0;
  }
  void fail() {
    damping *= growth;
    growth *= 2.0;
    most_in_a_row = std::max(most_in_a_row, ++in_a_row);
  }
};

TEST(BundleDamping, GrowsFasterWithEachStepThatFailsAndShrinksWithOneThatDoesNot) {
  int most_in_a_row = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    BundleOptions options;
    options.huber_mono = options.huber_stereo = 0.0;
    options.least_gain = 1e-9;
    const Bundle start =
        bundle_scene({.cameras = 5, .points = 30, .views = 4, .pose_off = 0.6, .point_off = 3.0}, seed).bundle;
    BundleNormal normal(start, options, nullptr);
    Bundle expected = start;
    double cost = cost_of_bundle(start, options);
    Schedule schedule;
    for (int iteration = 1; iteration <= 14; ++iteration) {
      BundleStep step;
      ASSERT_TRUE(normal.solve(expected, schedule.damping, step));
      Bundle moved = stepped(expected, normal, step);
      const double next = cost_of_bundle(moved, options);
      if (next <= cost) {
        expected = std::move(moved);
        cost = next;
        schedule.succeed();
      } else {
        schedule.fail();
      }
      Bundle adjusted = start;
      options.iterations = iteration;
      const BundleResult result = adjust_bundle(adjusted, options);
      ASSERT_EQ(result.iterations, iteration);
      EXPECT_NEAR(result.last_cost, cost, 1e-6 * cost) << seed << ' ' << iteration;
      for (std::size_t i = 0; i < start.points.size(); ++i)
        ASSERT_LT((adjusted.points[i] - expected.points[i]).norm(), 1e-6 * expected.points[i].norm()) << iteration;
      if (result.converged) break;
    }
    most_in_a_row = std::max(most_in_a_row, schedule.most_in_a_row);
  }
  EXPECT_GE(most_in_a_row, 3) << "steps that fail";
}

TEST(BundleDamping, WithoutAnySolutionItGivesUpBeyondAHundredMillion) {
  Bundle bundle = bundle_scene({.cameras = 4, .points = 20, .views = 3}, 2).bundle;
  bundle.observations[5].ray.x() = std::numeric_limits<double>::quiet_NaN();
  BundleOptions options;
  options.iterations = 100;
  Schedule schedule;
  int expected = 0;
  for (; schedule.damping < 1e8; ++expected) schedule.fail();
  const BundleResult result = adjust_bundle(bundle, options);
  EXPECT_EQ(result.iterations, expected);
  EXPECT_FALSE(result.converged);
}

TEST(BundleDamping, ItConvergesOnceAStepGainsNoMoreThanTheShare) {
  const Bundle start = bundle_scene({.cameras = 5, .points = 40, .views = 4}, 4).bundle;
  BundleOptions options;
  std::vector<double> costs{cost_of_bundle(start, options)};
  options.least_gain = 0.0;
  for (options.iterations = 1; options.iterations <= 6; ++options.iterations) {
    Bundle bundle = start;
    costs.push_back(adjust_bundle(bundle, options).last_cost);
  }
  options.iterations = 100;
  for (std::size_t k = 1; k < 5; ++k) {
    const double gain = (costs[k - 1] - costs[k]) / costs[k - 1];
    if (!(gain > 1e-9)) break;
    for (const double share : {0.99 * gain, 1.01 * gain}) {
      options.least_gain = share;
      Bundle bundle = start;
      const BundleResult result = adjust_bundle(bundle, options);
      EXPECT_TRUE(result.converged);
      EXPECT_EQ(result.iterations == static_cast<int>(k), share > gain) << k;
    }
  }
}

TEST(BundleDamping, OnceStoppedNoFurtherStepIsTried) {
  for (const int after : {0, 1, 3}) {
    Bundle bundle = bundle_scene({}, 3).bundle;
    BundleOptions options;
    options.least_gain = 0.0;
    int asked = 0;
    options.stopped = [&] { return asked++ == after; };
    EXPECT_EQ(adjust_bundle(bundle, options).iterations, after);
  }
}

}  // namespace
}  // namespace rastro
