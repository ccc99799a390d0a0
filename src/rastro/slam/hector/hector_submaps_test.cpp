// SPDX-License-Identifier: Apache-2.0
// What submaps hold, when they are started and when loops are searched for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "rastro/map/scans/scan_layer.h"
#include "rastro/slam/hector/hector_slam.h"
#include "rastro/slam/hector/hector_testing.h"
#include "rastro/slam/hector/submap.h"

namespace rastro {
namespace {

using testing::ring_drive;
using testing::room_drive;
using testing::WalledDrive;

std::vector<SlamUpdate> updates_of(const std::vector<Frame>& frames, const HectorOptions& options) {
  HectorSlam slam(options, nullptr);
  std::vector<SlamUpdate> updates;
  for (const Frame& frame : frames) updates.push_back(slam.process(frame));
  return updates;
}

bool has_event(const SlamUpdate& update, const char* kind) {
  return std::any_of(update.events.begin(), update.events.end(), [&](const SlamEvent& e) { return e.kind == kind; });
}

Submap submap_of(const WalledDrive& drive) {
  const HectorOptions options;
  Submap submap(options, SE2());
  for (std::size_t k = 0; k < drive.world_from_body.size(); ++k)
    submap.insert(returns_of(drive.scan(k), options), drive.ground_truth(k), k);
  return submap;
}

/// By level, as the matchers read them.
std::vector<std::vector<std::uint8_t>> cells_of(const Submap& submap) {
  std::vector<std::vector<std::uint8_t>> cells;
  for (const ProbabilityView& view : submap.levels())
    cells.emplace_back(view.cells, view.cells + view.width * view.height);
  return cells;
}

TEST(Submap, FinishingKeepsTheCellsOfEachLevelAndFreesMemory) {
  Submap submap = submap_of(room_drive(5));
  const auto cells = cells_of(submap);
  const std::size_t bytes = submap.bytes();
  ASSERT_EQ(cells.size(), static_cast<std::size_t>(HectorOptions().levels));
  submap.finish();
  EXPECT_TRUE(submap.finished());
  EXPECT_TRUE(cells_of(submap) == cells);
  EXPECT_LT(submap.bytes(), bytes);
}

TEST(Submap, SearchDataCountsAsMemoryWhileItIsKept) {
  Submap submap = submap_of(room_drive(5));
  const std::size_t bytes = submap.bytes(), finest = cells_of(submap).front().size();
  submap.correlative();
  EXPECT_EQ(submap.bytes(), bytes + 7 * finest) << "a byte for each cell of seven levels";
  submap.forget_correlative();
  EXPECT_EQ(submap.bytes(), bytes);
  submap.correlative();
  submap.release();
  EXPECT_TRUE(submap.released());
  EXPECT_LT(submap.bytes(), finest);
}

/// The search follows every so many key scans, so a closed loop is reported with one of these counts.
TEST(HectorSlam, SearchesForLoopsEverySoManyKeyScansAndNotBetween) {
  WalledDrive drive = ring_drive();
  drive.measured_m = 1.02;
  const std::vector<Frame> frames = drive.frames();
  for (const int every : {1, 7, 1000}) {
    HectorOptions options;
    options.optimize_every = every;
    int key_scans = 1, closed = 0;
    for (const SlamUpdate& update : updates_of(frames, options)) {
      key_scans += has_event(update, "keyframe") ? 1 : 0;
      if (!has_event(update, "loop_closed")) continue;
      ++closed;
      EXPECT_TRUE(has_event(update, "keyframe")) << "nothing new to search for";
      EXPECT_EQ(key_scans % every, 0) << key_scans;
      EXPECT_TRUE(has_event(update, "map_revised"));
    }
    EXPECT_GT(key_scans, 100);
    EXPECT_EQ(closed > 0, every < 1000) << every;
  }
}

TEST(HectorSlam, APoseIsAsUncertainAsItsCellsAndMoreFromSubmapToSubmap) {
  HectorOptions options;
  const double of_cells_m = 0.3 * options.cell_m;
  double first = 0.0, last = 0.0;
  for (const SlamUpdate& update : updates_of(ring_drive().frames(), options)) {
    if (!update.covariance || update.reason == SlamReason::first_frame) continue;
    last = std::sqrt(update.covariance->topLeftCorner<2, 2>().trace());
    if (first == 0.0) first = last;
    EXPECT_GT(last, of_cells_m) << update.index;
  }
  EXPECT_GT(last, 1.5 * first);
}

/// Scans are matched with the oldest submap that is not finished: while that is the first one, its cells are all that
/// they inherit, though the next has begun.
TEST(HectorSlam, APoseIsAsUncertainAsTheOldestOpenSubmap) {
  HectorOptions options;
  options.submap_scans = 10;
  options.submap_insert_distance_m = 0.1;
  std::vector<std::vector<double>> variances(1);  // by the number of submaps begun
  for (const SlamUpdate& update : updates_of(room_drive(60).frames(), options)) {
    if (update.reason == SlamReason::first_frame) continue;
    ASSERT_TRUE(update.covariance);
    variances.back().push_back(update.covariance->topLeftCorner<2, 2>().trace());
    if (has_event(update, "submap")) variances.emplace_back();
  }
  ASSERT_GE(variances.size(), 4U);
  const auto range = [&](std::size_t begun) {
    return std::minmax_element(variances[begun].begin(), variances[begun].end());
  };
  ASSERT_GT(variances[2].size(), 2U);
  EXPECT_LT(*range(1).second, 1.5 * *range(0).first) << "the second has begun";
  EXPECT_GT(*range(2).first, 1.2 * *range(0).first) << "the first is finished, whose scans the second was matched with";
}

TEST(HectorSlam, ASubmapIsStartedEveryHalfSubmap) {
  HectorOptions options;
  for (const int scans : {10, 7}) {
    options.submap_scans = scans;
    const int half = scans / 2;
    int key_scans = 1, submaps = 1;
    for (const SlamUpdate& update : updates_of(room_drive(100).frames(), options)) {
      if (!has_event(update, "keyframe")) continue;
      EXPECT_EQ(has_event(update, "submap"), ++key_scans % half == 0) << key_scans;
      submaps += has_event(update, "submap") ? 1 : 0;
    }
    EXPECT_EQ(submaps, 1 + key_scans / half);
  }
}

TEST(HectorSlam, ASnapshotHasTheKeyScansAndEveryScanRelativeToOne) {
  const std::vector<Frame> frames = room_drive(30).frames();
  HectorSlam slam({}, nullptr);
  std::vector<std::int64_t> key_frames{0};
  for (const Frame& frame : frames) {
    const SlamUpdate update = slam.process(frame);
    if (has_event(update, "keyframe")) key_frames.push_back(update.index);
  }
  const auto map = slam.snapshot();
  EXPECT_EQ(contradiction_in(*map), "");
  ASSERT_EQ(map->keyframes.size(), key_frames.size());
  for (std::size_t k = 0; k < key_frames.size(); ++k) {
    const Keyframe& keyframe = map->keyframes[k];
    EXPECT_EQ(keyframe.id, static_cast<KeyframeId>(k));
    EXPECT_EQ(keyframe.frame, key_frames[k]);
    EXPECT_EQ(keyframe.stamp, frames[static_cast<std::size_t>(key_frames[k])].stamp);
    EXPECT_EQ(keyframe.parent, k == 0 ? no_keyframe : static_cast<KeyframeId>(k) - 1);
    EXPECT_EQ(keyframe.submap, 0);
    EXPECT_EQ(keyframe.weight, 1.0);
    EXPECT_EQ(map->layer<ScanLayer>()->of.at(keyframe.id)->size(), 1U);
  }
  const Trajectory trajectory = slam.trajectory(), of_map = trajectory_of(*map);
  ASSERT_EQ(of_map.size(), trajectory.size());
  for (std::size_t k = 0; k < trajectory.size(); ++k) {
    EXPECT_EQ(of_map[k].stamp, trajectory[k].stamp);
    EXPECT_LT((of_map[k].world_from_body.matrix() - trajectory[k].world_from_body.matrix()).norm(), 1e-9) << k;
  }
  ASSERT_EQ(map->sessions.size(), 1U);
  const MapSession& session = map->sessions.front();
  EXPECT_EQ(session.robot, 0);
  EXPECT_EQ(session.session, 0);
  EXPECT_EQ(session.first_stamp, frames.front().stamp);
  EXPECT_EQ(session.last_stamp, frames.back().stamp);
  EXPECT_TRUE(session.scale.metric);
  const MapSession empty = HectorSlam({}, nullptr).snapshot()->sessions.front();
  EXPECT_EQ(empty.first_stamp, 0);
  EXPECT_EQ(empty.last_stamp, 0);
}

}  // namespace
}  // namespace rastro
