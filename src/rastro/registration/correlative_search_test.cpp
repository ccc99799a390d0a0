// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/correlative_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

struct CellPose {
  int rotation = 0, x = 0, y = 0;
};

/// A small random map, points and a search window.
struct Case {
  std::vector<std::uint8_t> cells;
  ProbabilityView map;
  std::vector<Eigen::Vector2d> points;
  SE2 guess;
  CorrelativeWindow window;
};

/// `values`: number of different cell values; few make equal scores likely.
Case random_case(Random& random, std::uint32_t values) {
  Case made;
  made.map.width = 8 + static_cast<int>(random.below(25));
  made.map.height = 8 + static_cast<int>(random.below(25));
  made.map.cell_m = 0.1;
  made.map.origin = {random.uniform(-5.0, 5.0), random.uniform(-5.0, 5.0)};
  made.cells.resize(static_cast<std::size_t>(made.map.width) * static_cast<std::size_t>(made.map.height));
  for (std::uint8_t& cell : made.cells) {
    const bool occupied = random.uniform() < 0.3;
    cell = static_cast<std::uint8_t>(occupied ? 255 - 20 * random.below(values) : random.below(129));
  }
  made.map.cells = made.cells.data();
  const Eigen::Vector2d middle =
      made.map.origin + 0.5 * made.map.cell_m * Eigen::Vector2d(made.map.width, made.map.height);
  made.guess = SE2(SO2::from_angle(random.uniform(-3.0, 3.0)), middle);
  const std::uint32_t count = 1 + random.below(12);
  for (std::uint32_t i = 0; i < count; ++i)
    made.points.emplace_back(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5));
  made.window = {random.uniform(0.05, 0.9), random.uniform(0.01, 0.4), 0.0};
  return made;
}

/// Moves nine in ten points by at most a cell.
double step_rad(const Case& made) {
  std::vector<double> ranges;
  for (const Eigen::Vector2d& point : made.points) ranges.push_back(point.norm());
  std::sort(ranges.begin(), ranges.end());
  return made.map.cell_m / std::max(made.map.cell_m, ranges[ranges.size() * 9 / 10]);
}

SE2 pose_at(const Case& made, const CellPose& at_cell) {
  return {made.guess.rotation() * SO2::from_angle(at_cell.rotation * step_rad(made)),
          made.guess.translation() + made.map.cell_m * Eigen::Vector2d(at_cell.x, at_cell.y)};
}

/// Sum of the cells at the endpoints that are known to be occupied.
int sum_at(const Case& made, const CellPose& at_cell) {
  const SE2 rotated = pose_at(made, {at_cell.rotation, 0, 0});
  int sum = 0;
  for (const Eigen::Vector2d& point : made.points) {
    const Eigen::Vector2d at = (rotated * point - made.map.origin) / made.map.cell_m;
    const int x = static_cast<int>(std::floor(at.x())) + at_cell.x,
              y = static_cast<int>(std::floor(at.y())) + at_cell.y;
    if (x < 0 || y < 0 || x >= made.map.width || y >= made.map.height) continue;
    const int value = made.map.cells[static_cast<std::ptrdiff_t>(y) * made.map.width + x];
    if (value > 128) sum += value;
  }
  return sum;
}

struct BruteForce {
  int best_sum = -1, least_rotation = 0;  ///< The smallest rotation, of either sign, that reaches the best score.
  int equals = 0;
};

BruteForce look_everywhere(const Case& made) {
  BruteForce best;
  const int steps = static_cast<int>(std::ceil(made.window.reach_rad / step_rad(made)));
  const int reach = static_cast<int>(std::ceil(made.window.reach_m / made.map.cell_m));
  for (int rotation = -steps; rotation <= steps; ++rotation) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const int sum = sum_at(made, {rotation, x, y});
        if (sum > best.best_sum) best = {sum, std::abs(rotation), 0};
        if (sum == best.best_sum) {
          ++best.equals;
          best.least_rotation = std::min(best.least_rotation, std::abs(rotation));
        }
      }
    }
  }
  return best;
}

/// Index of a pose on the raster; the test fails if it is not on it.
CellPose cell_pose_of(const Case& made, const SE2& pose) {
  const double rotation = (made.guess.rotation().inverse() * pose.rotation()).angle() / step_rad(made);
  const Eigen::Vector2d offset = (pose.translation() - made.guess.translation()) / made.map.cell_m;
  const CellPose at_cell{static_cast<int>(std::lround(rotation)), static_cast<int>(std::lround(offset.x())),
                         static_cast<int>(std::lround(offset.y()))};
  EXPECT_NEAR(rotation, at_cell.rotation, 1e-6);
  EXPECT_NEAR(offset.x(), at_cell.x, 1e-6);
  EXPECT_NEAR(offset.y(), at_cell.y, 1e-6);
  const int reach = static_cast<int>(std::ceil(made.window.reach_m / made.map.cell_m));
  EXPECT_LE(std::max(std::abs(at_cell.x), std::abs(at_cell.y)), reach);
  return at_cell;
}

void expect_best(const Case& made, int levels, const BruteForce& best) {
  const auto found = CorrelativeMap(made.map, levels).search(made.points, made.guess, made.window);
  ASSERT_TRUE(found);
  const CellPose at_cell = cell_pose_of(made, found->map_from_body);
  EXPECT_EQ(sum_at(made, at_cell), best.best_sum);
  EXPECT_DOUBLE_EQ(found->score, best.best_sum / (255.0 * static_cast<double>(made.points.size())));
  EXPECT_EQ(std::abs(at_cell.rotation), best.least_rotation) << "of equal ones the one of smallest rotation";
}

TEST(CorrelativeSearch, EqualsBruteForce) {
  Random random(21);
  for (int round = 0; round < 120; ++round) {
    const Case made = random_case(random, 7);
    const BruteForce best = look_everywhere(made);
    for (const int levels : {1, 2, 4, 7}) expect_best(made, levels, best);
  }
}

TEST(CorrelativeSearch, EqualsBruteForceWithManyEqualScores) {
  Random random(22);
  int with_equals = 0;
  for (int round = 0; round < 80; ++round) {
    const Case made = random_case(random, 1);
    const BruteForce best = look_everywhere(made);
    with_equals += best.equals > 1 ? 1 : 0;
    for (const int levels : {1, 3, 5}) expect_best(made, levels, best);
  }
  EXPECT_GT(with_equals, 30);
}

TEST(CorrelativeSearch, FindsNothingBelowTheMinimumScore) {
  Random random(23);
  for (int round = 0; round < 40; ++round) {
    Case made = random_case(random, 7);
    const double best = look_everywhere(made).best_sum / (255.0 * static_cast<double>(made.points.size()));
    const CorrelativeMap map(made.map, 4);
    made.window.least_score = best - 1e-6;
    const auto just = map.search(made.points, made.guess, made.window);
    ASSERT_TRUE(just);
    EXPECT_DOUBLE_EQ(just->score, best);
    made.window.least_score = best + 1e-6;
    EXPECT_FALSE(map.search(made.points, made.guess, made.window));
  }
}

TEST(CorrelativeSearch, CellsNotKnownToBeOccupiedCountNothing) {
  const std::vector<std::uint8_t> cells(400, 128);
  const CorrelativeMap map({cells.data(), 20, 20, 0.1, {-1.0, -1.0}}, 4);
  const std::vector<Eigen::Vector2d> points{{0.3, 0.2}, {-0.4, 0.1}};
  EXPECT_FALSE(map.search(points, SE2(), {0.5, 0.3, 0.01}));
  EXPECT_FALSE(map.search({}, SE2(), {0.5, 0.3, 0.0})) << "no points";
}

TEST(CorrelativeSearch, AnImplausiblyFarGuessFindsNothing) {
  const std::vector<std::uint8_t> cells(400, 255);
  const CorrelativeMap map({cells.data(), 20, 20, 0.1, {-1.0, -1.0}}, 4);
  const std::vector<Eigen::Vector2d> points{{0.3, 0.2}, {-0.4, 0.1}};
  EXPECT_FALSE(map.search(points, SE2(SO2(), {1e4, -1e4}), {0.5, 0.3, 0.01}));
  const auto here = map.search(points, SE2(), {0.2, 0.3, 0.5});
  ASSERT_TRUE(here);
  EXPECT_DOUBLE_EQ(here->score, 1.0);
}

TEST(CorrelativeSearch, CopiesTheMap) {
  Random random(24);
  Case made = random_case(random, 7);
  const CorrelativeMap map(made.map, 4);
  const auto before = map.search(made.points, made.guess, made.window);
  std::fill(made.cells.begin(), made.cells.end(), std::uint8_t{0});
  const auto after = map.search(made.points, made.guess, made.window);
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->score, after->score);
  EXPECT_EQ(before->map_from_body.translation(), after->map_from_body.translation());
}

}  // namespace
}  // namespace rastro
