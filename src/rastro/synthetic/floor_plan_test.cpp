// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/floor_plan.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/base/text_file.h"
#include "rastro/synthetic/worlds/corridor.h"

namespace rastro {
namespace {

TEST(VisitCells, goes_from_cell_to_neighbor_and_skips_none) {
  Random random(3);
  for (int line = 0; line < 500; ++line) {
    const Eigen::Vector2d from(random.uniform(-9, 9), random.uniform(-9, 9)),
        to(random.uniform(-9, 9), random.uniform(-9, 9));
    std::vector<std::pair<int, int>> cells;
    visit_cells(from, to, [&](int x, int y) { cells.emplace_back(x, y); });
    EXPECT_EQ(cells.front(), std::pair(static_cast<int>(std::floor(from.x())), static_cast<int>(std::floor(from.y()))));
    EXPECT_EQ(cells.back(), std::pair(static_cast<int>(std::floor(to.x())), static_cast<int>(std::floor(to.y()))));
    for (std::size_t i = 1; i < cells.size(); ++i)
      ASSERT_EQ(std::abs(cells[i].first - cells[i - 1].first) + std::abs(cells[i].second - cells[i - 1].second), 1);
    std::size_t next = 0;  // Points along the line lie in the cells, in their order.
    for (double share = 0.0; share <= 1.0; share += 0.001) {
      const Eigen::Vector2d point = from + share * (to - from);
      const std::pair cell(static_cast<int>(std::floor(point.x())), static_cast<int>(std::floor(point.y())));
      while (next < cells.size() && cells[next] != cell) ++next;
      ASSERT_LT(next, cells.size()) << "a cell was skipped";
    }
  }
}

TEST(VisitCells, lines_along_an_axis_and_points_end) {
  int cells = 0;
  visit_cells({0.5, 0.5}, {0.5, 0.5}, [&](int, int) { ++cells; });
  EXPECT_EQ(cells, 1);
  visit_cells({3.5, 0.5}, {-2.5, 0.5}, [&](int, int) { ++cells; });
  EXPECT_EQ(cells, 8);
}

constexpr std::int64_t scans = 60;  // The first 3 m of the corridor.

const LaserWorld& world() {
  static const LaserWorld floor = make_corridor_floor();
  return floor;
}
const FloorPlan& plan() {
  static TaskPool pool(2);
  static const FloorPlan result = true_floor_plan(world(), scans, 0.05, pool);
  return result;
}

bool occupied_beside(const Eigen::Vector2d& point) {
  for (const double x : {-0.04, 0.0, 0.04})
    for (const double y : {-0.04, 0.0, 0.04})
      if (plan().at(point + Eigen::Vector2d(x, y)) == PlanCell::occupied) return true;
  return false;
}

TEST(FloorPlan, agrees_with_the_rays_cast_from_the_trajectory) {
  const LaserModel& laser = world().laser;
  for (std::int64_t scan = 0; scan < scans; scan += 7) {
    const SE2 at = world().world_from_body(world().time_of(scan)) * laser.body_from_laser;
    for (int beam = 0; beam < laser.beams; ++beam) {
      const double angle = at.rotation().angle() + laser.first_angle + beam * laser.angle_step;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      const auto hit = world().scene->trace_beside(0, {at.translation().x(), at.translation().y(), laser.height_m},
                                                   {direction.x(), direction.y(), 0.0}, laser.max_range);
      for (double range = 0.0; range < (hit ? hit->t : laser.max_range); range += 0.02)
        ASSERT_TRUE(plan().at(at.translation() + range * direction) != PlanCell::unknown) << scan << ' ' << angle;
      if (hit) {
        ASSERT_TRUE(occupied_beside(at.translation() + hit->t * direction)) << scan << ' ' << angle;
      }
    }
  }
}

TEST(FloorPlan, has_walls_glass_and_unobserved_cells) {
  EXPECT_EQ(plan().at({1.0, 0.0}), PlanCell::free);
  EXPECT_EQ(plan().at({1.0, 0.99}), PlanCell::free);
  EXPECT_EQ(plan().at({1.0, 1.01}), PlanCell::occupied) << "the wall's face is at y = 1";
  EXPECT_EQ(plan().at({1.0, 1.10}), PlanCell::unknown) << "inside the wall";
  EXPECT_EQ(plan().at({0.3, -1.075}), PlanCell::occupied) << "the glass door";
  EXPECT_EQ(plan().at({0.5, -3.0}), PlanCell::free) << "behind the glass";
  EXPECT_EQ(plan().at({-5.0, 8.0}), PlanCell::unknown) << "another corridor";
  EXPECT_EQ(plan().at({1e9, 0.0}), PlanCell::unknown);
}

TEST(FloorPlan, is_the_same_for_any_threads_and_is_written_in_the_format_of_map_server) {
  TaskPool one(1), three(3);
  const auto one_folder = scratch_folder("one"), three_folder = scratch_folder("three");
  write_floor_plan(true_floor_plan(world(), 12, 0.05, one), one_folder);
  write_floor_plan(true_floor_plan(world(), 12, 0.05, three), three_folder);
  const std::string pgm = read_text_file((one_folder / "floor_plan.pgm").string());
  EXPECT_EQ(pgm, read_text_file((three_folder / "floor_plan.pgm").string()));
  const std::string head = "P5\n# 0.05 m per cell\n" + std::to_string(plan().cells.width()) + " " +
                           std::to_string(plan().cells.height()) + "\n255\n";
  ASSERT_TRUE(pgm.starts_with(head));
  ASSERT_EQ(pgm.size(), head.size() + static_cast<std::size_t>(plan().cells.width() * plan().cells.height()));
  const auto gray = [&](double x, double y) {
    const int column = static_cast<int>(std::floor((x - plan().low.x()) / 0.05));
    const int row = plan().cells.height() - 1 - static_cast<int>(std::floor((y - plan().low.y()) / 0.05));
    return static_cast<int>(
        static_cast<unsigned char>(pgm[head.size() + static_cast<std::size_t>(row * plan().cells.width() + column)]));
  };
  EXPECT_EQ(gray(1.0, 0.0), 254);
  EXPECT_EQ(gray(1.0, 1.01), 0);
  EXPECT_EQ(gray(1.0, 1.10), 205);
  const std::string yaml = read_text_file((one_folder / "floor_plan.yaml").string());
  EXPECT_NE(yaml.find("image: floor_plan.pgm\nresolution: 0.05\norigin: ["), std::string::npos) << yaml;
}

}  // namespace
}  // namespace rastro
