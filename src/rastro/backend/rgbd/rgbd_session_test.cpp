// SPDX-License-Identifier: Apache-2.0
// What the tracker makes of the mapper's results, and how it searches the map while lost.
#include "rastro/backend/rgbd/rgbd_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "rastro/backend/rgbd/frame_report.h"
#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using ::testing::HasSubstr;
using testing::looking;
using testing::pose_near;
using testing::room_frame;
using testing::with_depth_noise;

RgbdSlamOptions many_keyframes() {
  RgbdSlamOptions options;
  options.backend_delay_frames = 5;
  options.keyframe_frames = 2;
  options.max_acceleration = 0.0;  // poses of these small noisy images jitter
  return options;
}

/// A noisy view of a pan along a wall, 30 frames/s.
Frame panned_frame(int k, const RgbdSlamOptions& options) {
  const SE3 view = looking({-0.5, -0.2 + 0.01 * k, 1.2}, -0.3 + 0.02 * k, -0.3);
  return with_depth_noise(room_frame(view, k), options, static_cast<std::uint64_t>(k));
}

/// While several keyframes wait for the mapper, its corrections of earlier ones move them and the tracker alike.
TEST(RgbdSession, TheLatestPoseIsThatOfTheTrajectoryWhateverIsPending) {
  const RgbdSlamOptions options = many_keyframes();
  RgbdSession session(options, test_room::camera(), {});
  double corrected = 0.0;
  SE3 last;
  for (int k = 0; k < 24; ++k) {
    const SlamUpdate update = session.process(panned_frame(k, options));
    const Trajectory trajectory = session.trajectory();
    ASSERT_EQ(trajectory.size(), static_cast<std::size_t>(k + 1));
    EXPECT_THAT(trajectory.back().world_from_body, pose_near(update.world_from_body, 1e-9, 1e-9)) << k;
    if (k > 0) {
      const SE3 before = trajectory[trajectory.size() - 2].world_from_body;
      corrected = std::max(corrected, (before.inverse() * last).log().norm());
    }
    last = update.world_from_body;
  }
  EXPECT_GT(corrected, 1e-5) << "nothing was corrected";
}

/// While mapping is off, frames refer to the keyframe they were last compared with.
TEST(RgbdSession, WithoutMappingTheMapIsComparedWithAfterSoManyFrames) {
  RgbdSlamOptions options = many_keyframes();
  for (const int every : {1, 1000}) {
    options.relocalize_every = every;
    RgbdSession session(options, test_room::camera(), {});
    for (int k = 0; k < 12; ++k) session.process(panned_frame(k, options));
    EXPECT_TRUE(session.set_mapping(false));
    const std::size_t mapped = session.snapshot()->frames.size();
    for (int k = 12; k < 23; ++k) {
      Frame back = panned_frame(22 - k, options);
      back.index = k;
      back.stamp = back.depth_stamp = panned_frame(k, options).stamp;
      EXPECT_EQ(session.process(back).state, SlamState::tracking) << k;
    }
    const auto map = session.snapshot();
    std::set<KeyframeId> keyframes;
    for (std::size_t i = mapped; i < map->frames.size(); ++i) keyframes.insert(map->frames[i].keyframe);
    EXPECT_EQ(map->frames.size(), 23U);
    EXPECT_EQ(keyframes.size() > 1, every == 1);
    EXPECT_TRUE(every == 1 || keyframes.contains(map->keyframes.back().id)) << "the last that was made";
  }
}

/// The shutter is closed: surfaces would go on by themselves, but what they agree with is a guess.
TEST(RgbdSession, ADarkImageIsALossWhateverTheDepthImageShows) {
  RgbdSession session(many_keyframes(), test_room::camera(), {});
  for (int k = 0; k < 6; ++k) session.process(panned_frame(k, many_keyframes()));
  Frame dark = panned_frame(6, many_keyframes());
  dark.image = GrayImage(dark.image.width(), dark.image.height());
  const SlamUpdate update = session.process(dark);
  EXPECT_EQ(update.state, SlamState::lost);
  EXPECT_EQ(update.reason, SlamReason::dark_or_blank);
  EXPECT_EQ(session.trajectory().size(), 6U);
}

/// The room with other images on its right two thirds: what another place of that make shows.
Frame repainted(Frame frame) {
  const GrayImage other = testing::unknown_frame(5).image;
  frame.color = {};
  for (int y = 0; y < other.height(); ++y)
    for (int x = other.width() / 3; x < other.width(); ++x) frame.image.at(x, y) = other.at(x, y);
  return frame;
}

Frame later(Frame frame, double seconds) {
  frame.stamp += from_seconds(seconds);
  frame.depth_stamp = frame.stamp;
  return frame;
}

/// The first step of a stair looks like the second, and features and surfaces may agree on either.
TEST(RgbdSession, APoseAfterAGapThatDoesNotLookLikeItIsDoubtful) {
  struct Case {
    bool same_image;
    double gap_s;
    bool doubtful;
  };
  const SE3 view = looking({-0.5, -0.2, 1.2}, -0.3, -0.3);
  const RgbdSlamOptions options;
  for (const Case& each : {Case{false, 0.4, true}, Case{false, 0.1, false}, Case{true, 0.4, false}}) {
    SCOPED_TRACE(each.gap_s);
    RgbdSession session(options, test_room::camera(), {});
    for (int k = 0; k < 3; ++k) session.process(with_depth_noise(room_frame(view, k), options, 1));
    const SE3 moved = looking({-0.48, -0.2, 1.2}, -0.3, -0.3);  // the same image again would be a repeated frame
    const Frame seen = with_depth_noise(room_frame(moved, 3), options, 2);
    const SlamUpdate update = session.process(later(each.same_image ? seen : repainted(seen), each.gap_s));
    EXPECT_EQ(update.detail.find("look different from keyframe 0") != std::string::npos, each.doubtful);
    EXPECT_EQ(update.state == SlamState::weak, each.doubtful) << update.detail;
    session.finish();
    const auto map = session.snapshot();
    if (!each.doubtful) continue;
    ASSERT_EQ(map->keyframes.size(), 2U) << "later frames are as uncertain";
    const auto tracked = std::find_if(map->constraints.begin(), map->constraints.end(),
                                      [](const Constraint& edge) { return edge.kind == ConstraintKind::odometry; });
    ASSERT_NE(tracked, map->constraints.end());
    EXPECT_GT(tracked->information.inverse()(0, 0), uncertain_edge_m * uncertain_edge_m);
  }
}

TEST(FrameReport, AKeptFrameHasWhatTheMapNeeds) {
  Frame frame = room_frame(looking({-0.5, -0.2, 1.2}, 0.0), 7);
  frame.mask = GrayImage(320, 240);
  frame.mask.at(3, 4) = 255;
  const Frame kept = kept_of(frame);
  EXPECT_EQ(kept.index, 7);
  EXPECT_EQ(kept.stamp, frame.stamp);
  EXPECT_EQ(kept.image.at(160, 120), frame.image.at(160, 120));
  EXPECT_EQ(kept.depth.at(160, 120), frame.depth.at(160, 120));
  ASSERT_EQ(kept.mask.width(), 320);
  EXPECT_EQ(kept.mask.at(3, 4), 255);
  EXPECT_EQ(kept.color.width(), frame.color.width());
}

/// The camera hardly moves, so that the number of frames decides.
TEST(RgbdSession, AKeyframeIsMadeAfterSoManyFrames) {
  RgbdSlamOptions options = many_keyframes();
  options.keyframe_frames = 4;
  RgbdSession session(options, test_room::camera(), {});
  for (int k = 0; k < 13; ++k) {
    const SE3 view = looking({-0.5, -0.2 + 0.0005 * k, 1.2}, 0.0, -0.3);
    const SlamUpdate update = session.process(with_depth_noise(room_frame(view, k), options, 1));
    const bool made = std::any_of(update.events.begin(), update.events.end(),
                                  [](const SlamEvent& event) { return event.kind == "keyframe"; });
    EXPECT_EQ(made, k % 4 == 0) << k;
  }
}

/// Back and forth along a wall: the map holds the places after two rounds, and does not grow with the time.
TEST(RgbdSession, NoKeyframeIsMadeWhereTheMapHasEnoughOfThem) {
  for (const int dense : {2, 1000}) {
    RgbdSlamOptions options = many_keyframes();
    options.keyframe_frames = 5;
    options.dense_keyframes = dense;
    RgbdSession session(options, test_room::camera(), {});
    std::size_t after_two_rounds = 0;
    SlamUpdate update;
    for (int k = 0; k < 96; ++k) {
      const int phase = k % 24, step = phase < 12 ? phase : 24 - phase;
      const SE3 view = looking({-0.5, -0.2 + 0.02 * step, 1.2}, -0.3 + 0.02 * step, -0.3);
      update = session.process(with_depth_noise(room_frame(view, k), options, static_cast<std::uint64_t>(k)));
      ASSERT_EQ(update.state, SlamState::tracking) << k << " " << update.detail;
      const SE3 first = looking({-0.5, -0.2, 1.2}, -0.3, -0.3);
      EXPECT_THAT(update.world_from_body, pose_near(first.inverse() * view, 0.02, 0.008)) << k;
      if (k == 48) after_two_rounds = session.snapshot()->keyframes.size();
    }
    session.finish();
    const auto map = session.snapshot();
    if (dense == 2) {
      EXPECT_LE(map->keyframes.size(), after_two_rounds + 1);
      EXPECT_LT(map->keyframes.size(), 12U);
      for (std::size_t a = 0; a < map->constraints.size(); ++a)
        EXPECT_NE(map->constraints[a].from, map->constraints[a].to);
    } else {
      EXPECT_GT(map->keyframes.size(), 17U);
    }
    EXPECT_EQ(session.trajectory().size(), 96U);
  }
}

TEST(RgbdSession, TheScoreIsTheShareOfInliers) {
  const RgbdSlamOptions options = many_keyframes();
  RgbdSession session(options, test_room::camera(), {});
  for (int k = 0; k < 6; ++k) {
    const SlamUpdate update = session.process(panned_frame(k, options));
    EXPECT_GT(update.score, 0.5) << k;
    EXPECT_LE(update.score, 1.0) << k;
  }
}

/// Elsewhere in the room nothing is found, and the detail says with how many keyframes the frame was compared.
TEST(RgbdSession, AHintNamesKeyframesToCompareFirstInAGivenMapAlone) {
  const auto map = std::make_shared<const Map>(make_test_map(6));
  const Frame elsewhere = room_frame(looking({0.0, -0.5, 1.2}, M_PI));
  RgbdSlamOptions options;
  options.relocalize_last = 6;
  for (const bool hinted : {false, true}) {
    SlamContext context;
    context.map = map;
    if (hinted) context.initial_pose = map->keyframes[2].world_from_camera;
    RgbdSession session(options, test_room::camera(), context);
    const SlamUpdate update = session.process(elsewhere);
    EXPECT_EQ(update.state, SlamState::lost);
    EXPECT_EQ(update.reason, SlamReason::not_found);
    EXPECT_THAT(update.detail, HasSubstr(hinted ? "none of 11 keyframes" : "none of 6 keyframes"));
  }
}

}  // namespace
}  // namespace rastro
