// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_slam.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "rastro/map/map_archive.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/synthetic/worlds/loop.h"

namespace rastro {
namespace {

/// A walk past houses, seen by a pair.
class WalkWithPair {
 public:
  static constexpr int first = 748, frames = 14;

  SlamUpdate process(LsdSlam& slam, int number) { return slam.process(frame(number)); }
  Frame frame(int number) {
    Frame frame;
    frame.index = number;
    frame.stamp = world_.stamp(first + number);
    frame.image = world_.render(first + number, pool_).gray;
    frame.right = world_.render_right(first + number, pool_).gray;
    return frame;
  }
  LsdSensor sensor() const {
    LsdSensor pair = single_camera(world_.camera());
    pair.kind = CameraKind::stereo;
    pair.baseline = world_.left_from_right()->translation().x();
    return pair;
  }
  SE3 first_from_camera(int number) const {
    return world_.world_from_camera(first).inverse() * world_.world_from_camera(first + number);
  }

 private:
  TaskPool pool_{1};
  World world_ = make_loop({.scale = 0.5, .threads = 1});
};

/// From the very first frame, without any alignment; and the covariance covers the errors.
TEST(LsdSlam, APairGivesPosesInMetersWithTheirCovariance) {
  WalkWithPair walk;
  LsdSlam slam({}, walk.sensor(), {});
  double squares = 0.0, moved = 0.0;
  int inside = 0;
  for (int k = 0; k < WalkWithPair::frames; ++k) {
    const SlamUpdate update = walk.process(slam, k);
    ASSERT_EQ(update.state, SlamState::tracking) << k << ' ' << update.detail;
    const SE3 truth = walk.first_from_camera(k);
    EXPECT_LT((update.world_from_body.translation() - truth.translation()).norm(), 0.03) << k;
    if (k == 0) continue;
    moved = truth.translation().norm();
    ASSERT_TRUE(update.covariance);
    Vector6d error;
    error << truth.translation() - update.world_from_body.translation(),
        (truth.rotation() * update.world_from_body.rotation().inverse()).log();
    const double nees = error.dot(update.covariance->ldlt().solve(error));
    squares += nees;
    inside += nees < 12.59;  // 95 % of chi-squared with 6 degrees of freedom
  }
  EXPECT_GT(moved, 0.5);
  EXPECT_GE(inside, (WalkWithPair::frames - 1) * 9 / 10);
  EXPECT_GT(squares / (WalkWithPair::frames - 1), 0.05) << "so large a covariance says nothing";
  const auto map = slam.snapshot();
  EXPECT_TRUE(scale_of(*map).metric);
  for (const Constraint& constraint : map->constraints) EXPECT_NEAR(constraint.from_from_to.scale(), 1.0, 1e-12);
}

/// Frames left out, and stamps that do not say so.
TEST(LsdSlam, AStepThatHardlyAnyCameraMakesIsWeak) {
  WalkWithPair walk;
  const auto state_after_step = [&](double max_acceleration) {
    LsdOptions options;
    options.max_acceleration = max_acceleration;
    LsdSlam slam(options, walk.sensor(), {});
    for (int k = 0; k < 4; ++k) walk.process(slam, k);
    Frame far = walk.frame(7);
    far.index = 4;
    far.stamp = walk.frame(4).stamp;
    return slam.process(far);
  };
  const SlamUpdate checked = state_after_step(LsdOptions().max_acceleration);
  EXPECT_EQ(checked.state, SlamState::weak);
  EXPECT_EQ(checked.reason, SlamReason::implausible_motion);
  EXPECT_EQ(state_after_step(0.0).state, SlamState::tracking);
}

/// As where a camera's driver drops a frame; the motion goes on meanwhile.
TEST(LsdSlam, ARepeatedImageHasTheLastPose) {
  WalkWithPair walk;
  LsdSlam slam({}, walk.sensor(), {});
  SlamUpdate last;
  for (int k = 0; k < 4; ++k) last = walk.process(slam, k);
  Frame again = walk.frame(3);
  again.index = 4;
  again.stamp = walk.frame(4).stamp;
  const SlamUpdate repeated = slam.process(again);
  EXPECT_EQ(repeated.state, SlamState::weak) << "the camera may have moved on";
  EXPECT_EQ(repeated.reason, SlamReason::repeated_frame);
  EXPECT_LT((repeated.world_from_body.inverse() * last.world_from_body).log().norm(), 1e-3);
  const SlamUpdate next = walk.process(slam, 5);
  EXPECT_EQ(next.state, SlamState::tracking) << next.detail;
  const Trajectory trajectory = slam.trajectory();
  ASSERT_EQ(trajectory.size(), 6U);
  EXPECT_EQ(trajectory[4].stamp, again.stamp);
  again.stamp = walk.frame(2).stamp;
  EXPECT_EQ(slam.process(again).state, SlamState::lost) << "a stamp that goes back";
  EXPECT_EQ(slam.trajectory().size(), 6U);
}

TEST(LsdSlam, AFrameThatIsFoundAgainInASubmapApartSaysSo) {
  constexpr int elsewhere = 300;
  WalkWithPair walk;
  LsdOptions options;
  options.lost_frames = 1;
  LsdSlam slam(options, walk.sensor(), {});
  for (int k = 0; k < 2; ++k) walk.process(slam, k);
  int number = elsewhere;
  SlamUpdate update = walk.process(slam, number);
  while (update.state == SlamState::lost && number < elsewhere + 5) update = walk.process(slam, ++number);
  ASSERT_EQ(update.reason, SlamReason::apart) << "else nothing is tested";
  Frame covered = walk.frame(++number);
  covered.image = covered.right = GrayImage(covered.image.width(), covered.image.height());
  ASSERT_EQ(slam.process(covered).state, SlamState::lost);
  const SlamUpdate found = walk.process(slam, ++number);
  EXPECT_EQ(found.state, SlamState::relocalized) << found.detail;
  EXPECT_EQ(found.reason, SlamReason::apart);
  EXPECT_FALSE(found.covariance);
}

/// Mapping beside tracking, or after it: its results are handed over at the same frames.
TEST(LsdSlam, EqualBytesWithMappingInAThreadOfItsOwn) {
  WalkWithPair walk;
  TaskPool pool(3);
  SlamContext beside;
  beside.pool = &pool;
  beside.pipelined = true;
  LsdSlam in_steps({}, walk.sensor(), {}), pipelined({}, walk.sensor(), beside);
  for (int k = 0; k < WalkWithPair::frames; ++k) {
    const SlamUpdate a = walk.process(in_steps, k), b = walk.process(pipelined, k);
    ASSERT_EQ(a.world_from_body.matrix(), b.world_from_body.matrix()) << k;
    ASSERT_EQ(a.events.size(), b.events.size()) << k;
  }
  in_steps.finish();
  pipelined.finish();
  const Trajectory a = in_steps.trajectory(), b = pipelined.trajectory();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k)
    EXPECT_EQ(a[k].world_from_body.matrix(), b[k].world_from_body.matrix()) << k;
}

class EagerArchive : public MapArchive {
 public:
  bool wants_map() const override { return true; }
  void keep(std::shared_ptr<const Map> map) override { maps.push_back(std::move(map)); }
  void add_images(KeyframeId, PackedImages) override {}
  std::shared_ptr<const ImageStore> images() const override { return nullptr; }

  std::vector<std::shared_ptr<const Map>> maps;
};

/// How often depends on the time that it takes, but the first frame that is mapped is there.
TEST(LsdSlam, AKilledRunLeavesAMapAndNoResultDependsOnThat) {
  constexpr int frames = 5;
  WalkWithPair walk;
  EagerArchive archive;
  SlamContext kept_safe;
  kept_safe.archive = &archive;
  LsdSlam alone({}, walk.sensor(), {}), kept({}, walk.sensor(), kept_safe);
  for (int k = 0; k < frames; ++k) {
    const Frame frame = walk.frame(k);
    ASSERT_EQ(alone.process(frame).world_from_body.matrix(), kept.process(frame).world_from_body.matrix()) << k;
  }
  ASSERT_FALSE(archive.maps.empty());
  const Map& map = *archive.maps.front();
  EXPECT_EQ(map.method, "lsd");
  EXPECT_EQ(map.keyframes.size(), 1U);
  EXPECT_EQ(map.frames.size(), 2U);
  ASSERT_TRUE(map.layer<SemiDenseLayer>());
  EXPECT_GT(map.layer<SemiDenseLayer>()->of.at(0)->pixels.size(), 100U);
}

class FullDisk : public EagerArchive {
 public:
  void keep(std::shared_ptr<const Map>) override { throw std::runtime_error("no space left"); }
};

TEST(LsdSlam, AnArchiveThatFailsCostsNeitherTrajectoryNorMap) {
  WalkWithPair walk;
  FullDisk disk;
  SlamContext context;
  context.archive = &disk;
  LsdSlam slam({}, walk.sensor(), context);
  int failures = 0;
  for (int k = 0; k < 5; ++k) {
    try {
      walk.process(slam, k);
    } catch (const std::runtime_error&) {
      ++failures;
    }
  }
  EXPECT_GT(failures, 0);
  EXPECT_GE(slam.trajectory().size(), 2U);
  EXPECT_EQ(slam.snapshot()->keyframes.size(), 1U);
}

/// To and fro between the same houses: the map is the same after every visit, and so are the poses.
TEST(LsdSlam, EarlierKeyframesGoOnWhereTheCameraComesBack) {
  constexpr int turn = 24, visits = 3;
  WalkWithPair walk;
  LsdSlam slam({}, walk.sensor(), {});
  std::vector<Frame> seen;
  for (int k = 0; k < turn; ++k) seen.push_back(walk.frame(k));
  std::size_t first_visit = 0;
  int returned = 0;
  for (int k = 0; k < 2 * visits * turn; ++k) {
    const int there = k % (2 * turn) < turn ? k % (2 * turn) : 2 * turn - 1 - k % (2 * turn);
    Frame frame = seen[static_cast<std::size_t>(there)];
    frame.index = k;
    frame.stamp = k * from_seconds(0.05);
    // The turn shows the same image twice, which is told as a repeated one.
    if (k > 0 && (k % turn) == 0) continue;
    const SlamUpdate update = slam.process(frame);
    // From one frame to the next it walks the other way, which is told too, for the two frames that show it.
    const bool turned = k > turn && k % turn <= 2 && update.reason == SlamReason::implausible_motion;
    ASSERT_EQ(update.state, turned ? SlamState::weak : SlamState::tracking) << k << ' ' << update.detail;
    EXPECT_LT((update.world_from_body.translation() - walk.first_from_camera(there).translation()).norm(), 0.03) << k;
    returned += static_cast<int>(std::count_if(update.events.begin(), update.events.end(),
                                               [](const SlamEvent& event) { return event.kind == "returned"; }));
    if (k == 2 * turn - 1) first_visit = slam.snapshot()->keyframes.size();
  }
  EXPECT_GT(first_visit, 2U);
  EXPECT_GT(returned, 0);
  EXPECT_LE(slam.snapshot()->keyframes.size(), first_visit + 1);
}

}  // namespace
}  // namespace rastro
