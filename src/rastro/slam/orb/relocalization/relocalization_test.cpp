// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/relocalization/relocalization.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tuple>
#include <utility>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/session_testing.h"

namespace rastro {
namespace {

using testing::ObserveOptions;
using testing::pose_near;
using testing::SessionBench;

/// Tracking is lost in a map of three keyframes; a frame of fewer than 100 points is tracked, but cannot be
/// relocalized.
struct RelocalizationBench : SessionBench {
  explicit RelocalizationBench(CameraKind sensor = CameraKind::mono, int init_frames = 60)
      : RelocalizationBench(sensor, options_with(init_frames)) {}
  RelocalizationBench(CameraKind sensor, const OrbSlamOptions& options, const SlamContext& context = {})
      : SessionBench(sensor, options, context), relocalization(session, tracker, pipeline, keyframes) {
    begin(3);
    session.tracking = false;
    session.lost_frames = 7;
    session.frame_number = 50;
  }
  static OrbSlamOptions options_with(int init_frames) {
    OrbSlamOptions options;
    options.relocalize_matches = 100;
    options.init_frames = init_frames;
    options.relocalize_frames = 1;
    return options;
  }
  std::optional<TrackingResult> relocalize(std::int64_t index, double k, const ObserveOptions& how = {}) {
    update.state = SlamState::lost;
    update.reason = SlamReason::not_found;
    update.detail = "before";
    const auto frame = observe(index, stop(k), how).frame;
    auto found = relocalization.relocalize(frame, update.events);
    if (found && !relocalization.confirm(frame, *found, update)) return std::nullopt;
    return found;
  }
  /// The next frame, tracked from an unconfirmed relocalization. Returns whether it confirms it.
  bool confirm(std::int64_t index, double k, const ObserveOptions& how = {}) {
    const auto frame = observe(index, stop(k), how).frame;
    const TrackingResult result = tracker.track(frame);
    EXPECT_TRUE(result.ok);
    return relocalization.confirm(frame, result, update);
  }
  /// A frame that observes nothing of the map.
  std::optional<TrackingResult> relocalize_elsewhere(std::int64_t index) {
    const testing::PointWorld other(300, 99);
    return relocalization.relocalize(other.observe(index, stop(1.0)).frame, update.events);
  }
  std::vector<std::int64_t> frames() const {
    std::vector<std::int64_t> indices;
    for (const TrackedFrame& frame : session.trajectory.frames()) indices.push_back(frame.index);
    return indices;
  }

  Relocalization relocalization;
  SlamUpdate update;
};

TEST(Relocalization, ARelocalizedFrameIsTrackedFromThenOn) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    RelocalizationBench bench(sensor);
    bench.tracker.restart(bench.stop(9.0), {}, nullptr);
    const auto found = bench.relocalize(10, 0.4);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->ok);
    EXPECT_THAT(found->camera_from_world, pose_near(bench.stop(0.4), 1e-4, 1e-5));
    EXPECT_TRUE(bench.session.tracking);
    EXPECT_EQ(bench.update.state, SlamState::relocalized);
    EXPECT_EQ(bench.update.reason, SlamReason::none);
    EXPECT_EQ(bench.update.detail, "");
    ASSERT_EQ(bench.update.events.size(), 1U);
    EXPECT_EQ(bench.update.events[0].kind, "relocalized");
    EXPECT_THAT(
        bench.update.events[0].detail,
        ::testing::MatchesRegex("in keyframe [012] with (29[0-9]|300) landmarks after 7 frames; .* of .* visible ones "
                                "fit, .* would by chance"));
    EXPECT_THAT(bench.tracker.last_pose(), pose_near(bench.stop(0.4), 1e-4, 1e-5));
    EXPECT_THAT(bench.tracker.velocity(), pose_near(SE3(), 0.0, 0.0));
    EXPECT_TRUE(bench.frames().empty()) << "the frame itself is left to who asked";
  }
}

TEST(Relocalization, NothingChangesWhereNothingIsFound) {
  RelocalizationBench bench;
  bench.pipeline.insert(bench.input(9, 2.2, 2), 0);
  EXPECT_FALSE(bench.relocalize(10, 1.0, {.to = 99}));
  EXPECT_FALSE(bench.session.tracking);
  EXPECT_EQ(bench.update.state, SlamState::lost);
  EXPECT_EQ(bench.update.detail, "before");
  EXPECT_EQ(bench.tracker.view()->center, 2);
  EXPECT_TRUE(bench.pipeline.idle()) << "the map was searched as it is";
}

TEST(Relocalization, LostFramesGetPosesBackToTheFirstThatCannotBeTracked) {
  RelocalizationBench bench;
  EXPECT_FALSE(bench.relocalize(10, 0.2, {.to = 60}));
  EXPECT_FALSE(bench.relocalize_elsewhere(11));
  EXPECT_FALSE(bench.relocalize(12, 0.6, {.to = 60}));
  EXPECT_FALSE(bench.relocalize(13, 0.8, {.to = 60}));
  ASSERT_TRUE(bench.relocalize(14, 1.0));
  EXPECT_EQ(bench.frames(), (std::vector<std::int64_t>{12, 13}));
  const Trajectory poses = bench.session.trajectory.trajectory(bench.session.graph, 0);
  EXPECT_THAT(poses[0].world_from_body, pose_near(bench.stop(0.6).inverse(), 1e-3, 1e-4));
  EXPECT_THAT(poses[1].world_from_body, pose_near(bench.stop(0.8).inverse(), 1e-3, 1e-4));
  EXPECT_THAT(bench.tracker.last_pose(), pose_near(bench.stop(1.0), 1e-4, 1e-5)) << "tracking goes on from the last";
  // The frames lost before are dropped.
  ASSERT_TRUE(bench.relocalize(15, 1.2));
  EXPECT_EQ(bench.frames().size(), 2U);
}

TEST(Relocalization, OnlyTheLastLostFramesAreKept) {
  RelocalizationBench bench(CameraKind::mono, 3);
  for (int k = 0; k < 4; ++k) EXPECT_FALSE(bench.relocalize(10 + k, 0.2 * k, {.to = 60}));
  ASSERT_TRUE(bench.relocalize(14, 0.8));
  EXPECT_EQ(bench.frames(), (std::vector<std::int64_t>{12, 13})) << "and the one that was found";
}

/// A new submap ended the earlier loss.
TEST(Relocalization, FramesOfAnEarlierLossGetNoPoses) {
  for (const bool lost_again : {false, true}) {
    RelocalizationBench bench;
    EXPECT_FALSE(bench.relocalize(10, 0.8, {.to = 60}));
    if (lost_again) bench.relocalization.on_lost();
    ASSERT_TRUE(bench.relocalize(11, 1.0));
    EXPECT_EQ(bench.frames().size(), lost_again ? 0U : 1U);
  }
}

TEST(Relocalization, NoKeyframeIsMadeRightAfter) {
  RelocalizationBench bench;
  ASSERT_TRUE(bench.relocalize(10, 1.0));
  TrackingResult weak;
  weak.reference = 1;
  weak.inliers = 200;
  const auto frame = bench.observe(11, bench.stop(1.0)).frame;
  bench.session.frame_number = 50 + 19;
  EXPECT_FALSE(bench.keyframes.needs_keyframe(*frame, weak));
  bench.session.frame_number = 50 + 20;
  EXPECT_TRUE(bench.keyframes.needs_keyframe(*frame, weak));
}

OrbSlamOptions confirmed_by(int frames) {
  OrbSlamOptions options = RelocalizationBench::options_with(60);
  options.relocalize_frames = frames;
  return options;
}

TEST(Relocalization, IsBelievedOnceEnoughFramesAgree) {
  RelocalizationBench bench(CameraKind::mono, confirmed_by(3));
  EXPECT_FALSE(bench.relocalize(9, 0.8, {.to = 60}));
  EXPECT_FALSE(bench.relocalize(10, 1.0));
  EXPECT_TRUE(bench.relocalization.is_unconfirmed());
  EXPECT_EQ(bench.update.state, SlamState::lost);
  EXPECT_EQ(bench.update.reason, SlamReason::unconfirmed);
  EXPECT_THAT(bench.update.detail, ::testing::HasSubstr("; 1 of 3 frames agree"));
  EXPECT_EQ(bench.session.lost_frames, 7) << "the frame was counted as lost before it was found";
  EXPECT_FALSE(bench.confirm(11, 1.1));
  EXPECT_THAT(bench.update.detail, ::testing::HasSubstr("; 2 of 3 frames agree"));
  EXPECT_EQ(bench.session.lost_frames, 8);
  EXPECT_TRUE(bench.frames().empty()) << "no frame has a pose yet";
  EXPECT_TRUE(bench.update.events.empty());
  EXPECT_TRUE(bench.confirm(12, 1.2));
  EXPECT_FALSE(bench.relocalization.is_unconfirmed());
  EXPECT_EQ(bench.update.state, SlamState::relocalized);
  EXPECT_EQ(bench.update.reason, SlamReason::none);
  EXPECT_EQ(bench.frames(), (std::vector<std::int64_t>{9, 10, 11})) << "those lost before and those unconfirmed";
  const Trajectory poses = bench.session.trajectory.trajectory(bench.session.graph, 0);
  for (const auto& [k, at] : {std::pair{0U, 0.8}, {1U, 1.0}, {2U, 1.1}})
    EXPECT_THAT(poses[k].world_from_body, pose_near(bench.stop(at).inverse(), 1e-3, 1e-4)) << k;
}

TEST(Relocalization, AFrameThatCannotBeTrackedRejectsIt) {
  RelocalizationBench bench(CameraKind::mono, confirmed_by(3));
  bench.relocalize(10, 1.0);
  bench.confirm(11, 1.1);
  bench.relocalization.reject();
  EXPECT_FALSE(bench.session.tracking);
  EXPECT_FALSE(bench.relocalization.is_unconfirmed());
  EXPECT_TRUE(bench.frames().empty());
  // The same frames get their poses when the map is found again.
  bench.relocalize(12, 1.2);
  bench.confirm(13, 1.3);
  EXPECT_TRUE(bench.confirm(14, 1.4));
  EXPECT_EQ(bench.frames(), (std::vector<std::int64_t>{10, 11, 12, 13}));
}

/// Words are the last thing that mapping gives a keyframe.
TEST(Relocalization, IsConfirmedInAMapThatNoJobIsWriting) {
  TaskPool pool(2);
  RelocalizationBench bench(CameraKind::mono, confirmed_by(3), {.pool = &pool, .pipelined = true});
  EXPECT_FALSE(bench.relocalize(10, 1.0));
  ASSERT_TRUE(bench.relocalization.is_unconfirmed());
  const auto input = bench.input(9, 2.2, 2);
  const auto frame = bench.observe(11, bench.stop(1.1)).frame;
  const TrackingResult result = bench.tracker.track(frame);
  bench.pipeline.insert(input, 0);
  EXPECT_FALSE(bench.relocalization.confirm(frame, result, bench.update));
  ASSERT_TRUE(bench.session.graph.has_keyframe(3));
  EXPECT_TRUE(bench.session.graph.keyframe(3).words);
  EXPECT_FALSE(bench.pipeline.idle()) << "the result is handed over in its time";
}

/// The number of the keyframe that a frame at stop 1.4 is found in, with this initial pose.
std::int64_t found_in(const std::optional<SE3>& initial_world_from_camera) {
  OrbSlamOptions options = RelocalizationBench::options_with(60);
  options.place_candidates = 1;
  RelocalizationBench bench(CameraKind::mono, options);
  bench.session.initial_pose = initial_world_from_camera;
  EXPECT_TRUE(bench.relocalize(10, 1.4));
  EXPECT_FALSE(bench.session.initial_pose) << "known by now";
  return std::stoll(bench.update.events.at(0).detail.substr(std::string("in keyframe ").size()));
}

/// All keyframes observe the same; those that look 60 degrees elsewhere are not near.
TEST(Relocalization, AnInitialPoseSaysWhichKeyframeIsTriedFirst) {
  for (const int k : {0, 1, 2}) EXPECT_EQ(found_in(SessionBench::stop(k + 0.1).inverse()), k);
  const std::int64_t by_words = found_in(std::nullopt);
  for (const int k : {0, 1, 2}) {
    for (const double sign : {-1.0, 1.0}) {
      const auto turned = [&](double degrees) {
        return SessionBench::stop(k).inverse() * SE3(SO3::exp({0.0, sign * degrees * M_PI / 180.0, 0.0}), {0, 0, 0});
      };
      EXPECT_EQ(found_in(turned(59.0)), k);
      EXPECT_EQ(found_in(turned(61.0)), by_words);
    }
  }
}

/// The inliers of all frames together are compared with those that fit by chance.
TEST(Relocalization, InliersMustExceedThoseByChance) {
  for (const double ratio : {5.0, 1000.0}) {
    OrbSlamOptions options = confirmed_by(2);
    options.relocalize_chance_ratio = ratio;
    RelocalizationBench bench(CameraKind::mono, options);
    EXPECT_FALSE(bench.relocalize(10, 1.0));
    EXPECT_TRUE(bench.relocalization.is_unconfirmed()) << "less is asked of the first frame";
    EXPECT_EQ(bench.confirm(11, 1.1), ratio < 10.0) << bench.update.detail;
    if (ratio < 10.0) continue;
    EXPECT_EQ(bench.update.reason, SlamReason::not_found);
    EXPECT_THAT(bench.update.detail, ::testing::HasSubstr("visible landmarks fit"));
    EXPECT_FALSE(bench.session.tracking);
    EXPECT_FALSE(bench.relocalization.is_unconfirmed());
  }
}

/// Of what would be visible, half is not seen: a place that only looks alike.
TEST(Relocalization, WhatShouldBeVisibleMustBeSeen) {
  for (const double share : {0.3, 0.8}) {
    OrbSlamOptions options = confirmed_by(2);
    options.relocalize_visible_share = share;
    RelocalizationBench bench(CameraKind::mono, options);
    EXPECT_FALSE(bench.relocalize(10, 1.0, {.to = 150}));
    EXPECT_EQ(bench.confirm(11, 1.1, {.to = 150}), share < 0.5) << bench.update.detail;
    if (share < 0.5) continue;
    EXPECT_EQ(bench.update.reason, SlamReason::not_found);
    EXPECT_FALSE(bench.relocalization.is_unconfirmed());
  }
}

TEST(Relocalization, AFirstFrameNoBetterThanChanceRejectsIt) {
  OrbSlamOptions options = confirmed_by(3);
  options.relocalize_chance_ratio = options.min_chance_ratio = 1000.0;
  RelocalizationBench bench(CameraKind::mono, options);
  EXPECT_FALSE(bench.relocalize(10, 1.0));
  EXPECT_FALSE(bench.relocalization.is_unconfirmed());
  EXPECT_EQ(bench.update.reason, SlamReason::not_found);
}

/// A frame of 25 points: too little for a map that grows, enough where it only localizes.
TEST(Relocalization, AGivenMapAsksForFewerInliers) {
  for (const bool mapping : {true, false}) {
    OrbSlamOptions options = confirmed_by(1);
    options.relocalize_matches = 15;
    options.localization_distance_error = 0.0;  // the keyframes stand close together
    RelocalizationBench bench(CameraKind::mono, options);
    bench.session.mapping = mapping;
    bench.tracker.set_min_inliers(bench.session.min_inliers());
    EXPECT_EQ(bench.relocalize(10, 1.0, {.to = 25}).has_value(), !mapping) << bench.update.detail;
  }
}

TEST(Relocalization, WhereTheMotionWasLeadingOneFrameIsEnough) {
  for (const auto& [at, frames_later, enough] :
       {std::tuple{2.2, 2, true}, {2.9, 2, false}, {1.8, 2, true}, {0.5, 2, false}, {2.2, 9, false}}) {
    RelocalizationBench bench(CameraKind::mono, confirmed_by(3));
    bench.session.frame_number = 50;
    bench.relocalization.on_lost();  // standing at stop 2
    bench.session.frame_number = 50 + frames_later;
    EXPECT_EQ(bench.relocalize(10, at).has_value(), enough) << at << ' ' << frames_later;
  }
}

}  // namespace
}  // namespace rastro
