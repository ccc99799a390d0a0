// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/initialization/two_view_start.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rastro/synthetic/worlds/hall.h"
#include "rastro/synthetic/worlds/street.h"

namespace rastro {
namespace {

/// Depths of the first view against the true ones, in the unit that fits best.
TEST(TwoViewStart, DepthsOfTheFirstViewAreTrueButForTheUnit) {
  const World world = make_hall({.seed = 2, .scale = 0.5});
  TaskPool pool(2);
  TwoViewStart start({}, world.camera(), &pool);
  std::optional<TwoViewStart::Result> found;
  for (int k = 0; k < 30 && !found; ++k) found = start.take(k, k * 50'000'000, world.render(k, pool).gray);
  ASSERT_TRUE(found) << start.detail();
  EXPECT_NEAR(mean_inverse_depth(found->depth), 1.0, 1e-5);
  const RenderedFrame first = world.render(static_cast<int>(start.frames()[found->first].index), pool);
  std::vector<double> ratios;
  for (int y = 0; y < found->depth.height(); ++y)
    for (int x = 0; x < found->depth.width(); ++x)
      if (found->depth.is_known(x, y) && first.depth.at(x, y) > 0.0F)
        ratios.push_back(static_cast<double>(found->depth.mean.at(x, y) * first.depth.at(x, y)));
  ASSERT_GT(ratios.size(), 500U);
  std::sort(ratios.begin(), ratios.end());
  const double unit = ratios[ratios.size() / 2];
  const auto within =
      std::count_if(ratios.begin(), ratios.end(), [unit](double ratio) { return std::abs(ratio / unit - 1.0) < 0.1; });
  EXPECT_GT(static_cast<double>(within), 0.8 * static_cast<double>(ratios.size()));
}

/// Backward, little of what is followed stays in view until there is parallax.
TEST(TwoViewStart, IsFoundSoonWhereACarDrivesBackward) {
  const World world = make_street({.seed = 3, .scale = 0.5});
  TaskPool pool(2);
  for (const int last : {40, 120}) {
    TwoViewStart start({}, world.camera(), &pool);
    int taken = 0;
    bool found = false;
    for (; taken < 30 && !found; ++taken)
      found = start.take(taken, taken * 100'000'000, world.render(last - taken, pool).gray).has_value();
    EXPECT_TRUE(found) << "from frame " << last << ": " << start.detail();
    EXPECT_LE(taken, 8);
  }
}

TEST(TwoViewStart, ACameraThatStandsStillGivesNoDepth) {
  const World world = make_hall({.seed = 2, .scale = 0.5});
  TaskPool pool(2);
  TwoViewStart start({}, world.camera(), &pool);
  for (int k = 0; k < 20; ++k) EXPECT_FALSE(start.take(k, k * 50'000'000, world.render(0, pool).gray));
  EXPECT_NE(start.detail(), "");
}

}  // namespace
}  // namespace rastro
