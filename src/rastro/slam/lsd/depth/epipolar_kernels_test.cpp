// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/epipolar_kernels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/random.h"
#include "rastro/slam/lsd/depth/epipolar_search.h"

namespace rastro {
namespace {

constexpr int wall_width = 160, wall_height = 120;

/// Textured, with the right image as a camera 10 cm to the right sees a wall at `depth` meters.
GrayImage textured_wall(double shift_px) {
  GrayImage image(wall_width, wall_height);
  for (int y = 0; y < wall_height; ++y)
    for (int x = 0; x < wall_width; ++x) {
      const double u = x + shift_px;
      image.at(x, y) = static_cast<std::uint8_t>(128.0 + 60.0 * std::sin(0.31 * u + 0.07 * y) +
                                                 50.0 * std::sin(0.23 * y - 0.4 * u) * std::cos(0.05 * u));
    }
  return image;
}

struct WallView {
  GrayImage keyframe = textured_wall(0.0), image = textured_wall(7.0), mask = GrayImage(wall_width, wall_height);
  EpipolarView view;

  explicit WallView(bool masked) {
    for (int y = 0; y < wall_height; ++y)
      for (int x = 0; x < wall_width; ++x) mask.at(x, y) = x > 100 && y < 60 ? 0 : 255;
    view.keyframe = keyframe.view(), view.image = image.view();
    if (masked) view.mask = mask.view();
    view.rotation[0] = view.rotation[4] = view.rotation[8] = 1.0F;
    view.translation[0] = -0.1F, view.translation[2] = 0.01F;
    view.center[0] = 0.1F, view.center[2] = -0.01F;
    view.fx = view.fy = 140.0F, view.cx = 79.5F, view.cy = 59.5F;
  }
};

/// Everywhere, beyond the edges too, with all kinds of intervals.
EpipolarQueries random_queries(int count, bool known, Random& random) {
  EpipolarQueries queries;
  queries.known = known;
  for (int i = 0; i < count; ++i) {
    const double expected = random.uniform(0.0, 1.0), reach = random.uniform(0.0, 1.5);
    DepthPrior prior{std::max(0.0, expected - reach), expected, expected + reach, known};
    if (random.below(2) == 0) prior.worthwhile_variance = random.uniform(0.0, 0.1);
    add_query(static_cast<int>(random.below(wall_width)), static_cast<int>(random.below(wall_height)), prior, queries);
  }
  return queries;
}

TEST(EpipolarKernels, FindTheSameBytesAndEveryKindOfResult) {
  Random random(1);
  std::array<int, epipolar_results> seen{};
  for (int trial = 0; trial < 400; ++trial) {
    const WallView view(trial % 2 == 0);
    const int count = 1 + static_cast<int>(random.below(epipolar_batch));
    const EpipolarQueries queries = random_queries(count, random.below(2) == 0, random);
    EpipolarMatches plain, fast;
    EpipolarView moved = view.view;
    moved.translation[2] = static_cast<float>(random.uniform(-1.0, 0.3));
    moved.center[2] = -moved.translation[2];
    moved.min_line_px = 3.0F;
    epipolar_kernels_plain().search(moved, queries, plain);
    epipolar_kernels_avx2().search(moved, queries, fast);
    for (int i = 0; i < count; ++i) {
      const EpipolarMatch a = match_at(plain, i), b = match_at(fast, i);
      ASSERT_EQ(a.result, b.result) << trial << ' ' << i;
      ASSERT_EQ(a.mean, b.mean);
      ASSERT_EQ(a.variance, b.variance);
      ++seen[static_cast<std::size_t>(a.result)];
    }
  }
  for (const int count : seen) EXPECT_GT(count, 0);
}

/// A wall that is 2 m away: 7 pixels of disparity.
TEST(EpipolarKernels, FindTheShiftOfATranslation) {
  WallView view(false);
  view.view.translation[2] = view.view.center[2] = 0.0F;
  EpipolarQueries queries;
  for (int x = 20; x < 140; ++x) add_query(x, 60, {0.2, 0.5, 0.8}, queries);
  EpipolarMatches matches;
  epipolar_kernels().search(view.view, queries, matches);
  int matched = 0;
  for (int i = 0; i < queries.count; ++i) {
    const EpipolarMatch match = match_at(matches, i);
    if (match.result != EpipolarResult::matched) continue;
    ++matched;
    EXPECT_NEAR(match.mean * 14.0F, 7.0F, 0.5F);
    EXPECT_GT(match.variance, 0.0F);
  }
  EXPECT_GT(matched, 60);
}

}  // namespace
}  // namespace rastro
