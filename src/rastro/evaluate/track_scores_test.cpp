// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/track_scores.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/evaluate/wall_ground_truth_testing.h"

namespace rastro {
namespace {

constexpr auto fresh = TrackState::fresh;
constexpr auto tracked = TrackState::tracked;
constexpr auto reidentified = TrackState::reidentified;
constexpr std::int64_t frames = 20;

TrackScoreOptions small_image_options() {
  TrackScoreOptions options;
  options.image_width = 200;
  options.image_height = 100;
  options.min_distance_px = 8.0;
  return options;
}

TrackScores score(const TableBuilder& builder, const TrackScoreOptions& options = small_image_options()) {
  return score_tracks(builder.table(), WallGroundTruth(frames), options);
}

enum class Oracle { recognizes, forgets, swaps };

/// A tracker with access to the ground truth: tracks wall points while they are visible and, when they reappear,
/// re-identifies them, calls them new, or gives each the id of its neighbor.
TableBuilder oracle_run(Oracle kind) {
  TableBuilder builder(frames);
  std::int64_t next_id = 100;
  for (int i = 0; i < 12; ++i) {
    const double x = -5.0 + i, y = i % 2 == 0 ? 0.0 : 2.0;
    std::int64_t id = i;
    bool seen = false, ever = false;
    for (std::int64_t k = 0; k < frames; ++k) {
      const Eigen::Vector2d pixel = WallGroundTruth::wall_pixel(k, x, y);
      const bool visible = WallGroundTruth::inside(pixel) && !WallGroundTruth::covered(k, pixel);
      const bool returns = visible && ever && !seen;
      if (returns && kind == Oracle::forgets) id = next_id++;
      if (returns && kind == Oracle::swaps) id = (i + 1) % 12;
      if (visible)
        builder.see(k, id, pixel, seen ? tracked : returns && kind != Oracle::forgets ? reidentified : fresh);
      seen = visible;
      ever = ever || visible;
    }
  }
  return builder;
}

TEST(TrackScores, OracleThatReidentifiesAllScoresOne) {
  const TrackScores scores = score(oracle_run(Oracle::recognizes));
  EXPECT_EQ(scores.lost, 12);
  EXPECT_EQ(scores.reappeared, 12);
  EXPECT_EQ(scores.recalled, 12);
  EXPECT_EQ(scores.reidentified, 12);
  EXPECT_EQ(scores.recall, 1.0);
  EXPECT_EQ(scores.precision, 1.0);
  EXPECT_EQ(scores.wrong, 0);
  EXPECT_EQ(scores.id_switches, 0);
  EXPECT_NEAR(scores.drift_median_px.value(), 0.0, 1e-5);
}

TEST(TrackScores, TrackerWithoutReidentificationHasNoRecallAndNoPrecision) {
  const TrackScores scores = score(oracle_run(Oracle::forgets));
  EXPECT_EQ(scores.reappeared, 12);
  EXPECT_EQ(scores.recall, 0.0);
  EXPECT_EQ(scores.reidentified, 0);
  EXPECT_FALSE(scores.precision.has_value());
  EXPECT_EQ(scores.misses.not_reidentified, 12);
}

TEST(TrackScores, SwappedIdsHaveNoPrecision) {
  const TrackScores scores = score(oracle_run(Oracle::swaps));
  EXPECT_GT(scores.reidentified, 5);
  EXPECT_EQ(scores.correct, 0);
  EXPECT_EQ(scores.precision, 0.0);
  EXPECT_EQ(scores.recalled, 0);
  EXPECT_GE(scores.id_switches, scores.reidentified);
}

// The wall point (0, 1) is occluded in frames 6 to 8.
TEST(TrackScores, LossIsCountedInTheFrameWhereTheIdIsMissing) {
  const TrackScores scores =
      score(TableBuilder(frames).follow(0, 5, 7, 0, 1, fresh).follow(9, 12, 7, 0, 1, reidentified));
  EXPECT_EQ(scores.lost, 1);
  EXPECT_EQ(scores.frames[6].lost, 1);
  EXPECT_EQ(scores.frames[9].reappeared, 1);
  EXPECT_EQ(scores.frames[9].recalled, 1);
  EXPECT_EQ(scores.frames[9].correct, 1);
  EXPECT_EQ(scores.lost_visible, 1) << "the second end, in frame 12, is a loss of a visible point";
  EXPECT_EQ(scores.frames[13].lost_visible, 1);
}

TEST(TrackScores, ReidentificationAfterTheWindowIsNotRecalled) {
  TrackScoreOptions options = small_image_options();
  const TableBuilder builder = TableBuilder(frames).follow(0, 5, 7, 0, 1, fresh).follow(9, 19, 7, 0, 1, reidentified);
  options.window = 4;
  EXPECT_EQ(score(builder, options).recalled, 1);
  options.window = 3;
  const TrackScores scores = score(builder, options);
  EXPECT_EQ(scores.lost, 1);
  EXPECT_EQ(scores.reappeared, 0) << "occluded to the end of the window";
  EXPECT_FALSE(scores.recall.has_value());
  EXPECT_EQ(scores.correct, 1) << "precision counts every re-identification, whatever the window";
}

TEST(TrackScores, FeatureLostWhileVisibleAndReidentifiedCountsForPrecisionOnly) {
  const TrackScores scores =
      score(TableBuilder(frames).follow(0, 2, 7, 4, 1, fresh).follow(5, 6, 7, 4, 1, reidentified));
  EXPECT_EQ(scores.frames[3].lost_visible, 1);
  EXPECT_EQ(scores.reidentified, 1);
  EXPECT_EQ(scores.correct, 1);
  EXPECT_EQ(scores.recalled, 0);
}

TEST(TrackScores, FeatureThatLeavesTheImageIsLostOutside) {
  // At x = -9.6 the point leaves through the left edge: pixel 4 - 0.5 k.
  TrackScores scores = score(TableBuilder(frames).follow(0, 8, 7, -9.6, 1, fresh));
  EXPECT_EQ(scores.lost_outside, 1);
  EXPECT_EQ(scores.lost_visible + scores.lost, 0);
  scores = score(TableBuilder(frames).follow(0, 2, 7, -9.3, 1, fresh));
  EXPECT_EQ(scores.lost_outside, 1) << "7 px from the edge is inside the border";
  TrackScoreOptions options = small_image_options();
  options.border_px = 2.0;
  EXPECT_EQ(score(TableBuilder(frames).follow(0, 2, 7, -9.3, 1, fresh), options).lost_visible, 1);
}

TEST(TrackScores, ReappearanceInTheBorderIsNotCounted) {
  // Point (0, 4.5) is observed in row 95 and occluded in frames 6 to 8.
  const TableBuilder builder = TableBuilder(frames).follow(0, 5, 7, 0, 4.5, fresh);
  TrackScoreOptions options = small_image_options();
  EXPECT_EQ(score(builder, options).lost, 1);
  EXPECT_EQ(score(builder, options).reappeared, 0);
  options.border_px = 4.0;
  EXPECT_EQ(score(builder, options).reappeared, 1);
}

TEST(TrackScores, CornerOnTheOccluderIsWrong) {
  // In frame 9 the board's left edge is 1 px right of the wall point (0.4, 1): a corner 2 px right of it is on the
  // board.
  const std::int64_t k = 9;
  const double edge = 100 + 100 * (WallGroundTruth::board_left(k) - WallGroundTruth::camera_x(k)) / 5.0;
  const double x = WallGroundTruth::camera_x(k) + (edge - 1.0 - 100.0) / 10.0;
  TableBuilder builder(frames);
  builder.follow(0, 5, 7, x, 1, fresh);
  const Eigen::Vector2d pixel = WallGroundTruth::wall_pixel(k, x, 1);
  ASSERT_FALSE(WallGroundTruth::covered(k, pixel));
  TableBuilder right = builder, wrong = builder;
  right.see(k, 7, pixel - Eigen::Vector2d(2, 0), reidentified);
  wrong.see(k, 7, pixel + Eigen::Vector2d(2, 0), reidentified);
  EXPECT_EQ(score(right).correct, 1);
  EXPECT_EQ(score(wrong).wrong, 1);
  EXPECT_EQ(score(wrong).wrongs.on_occluder, 1);
  EXPECT_EQ(score(wrong).misses.wrong_position, 1);
}

TEST(TrackScores, EachKindOfErrorIsCounted) {
  TableBuilder builder(frames);
  builder.follow(0, 5, 1, 0, 1, fresh).see(7, 1, WallGroundTruth::wall_pixel(7, 0, 1), reidentified);  // still occluded
  builder.follow(0, 5, 2, 0, 3, fresh).see(12, 2, WallGroundTruth::wall_pixel(12, 0.4, 3), reidentified);  // error 4 px
  builder.follow(0, 2, 3, -9.8, 1, fresh).see(19, 3, WallGroundTruth::wall_pixel(19, 0, 2), reidentified);
  builder.see(15, 4, WallGroundTruth::wall_pixel(15, 3, 1), reidentified);
  const TrackScores scores = score(builder);
  EXPECT_EQ(scores.wrong, 4);
  EXPECT_EQ(scores.wrongs.anchor_occluded, 1);
  EXPECT_EQ(scores.wrongs.other_position, 1);
  EXPECT_EQ(scores.wrongs.anchor_outside, 1);
  EXPECT_EQ(scores.wrongs.unknown_id, 1);
}

TEST(TrackScores, ToleranceDecides) {
  TrackScoreOptions options = small_image_options();
  const TableBuilder builder =
      TableBuilder(frames).follow(0, 5, 2, 0, 3, fresh).follow(12, 12, 2, 0.4, 3, reidentified);
  options.tolerance_px = 3.9;
  EXPECT_EQ(score(builder, options).precision, 0.0);
  options.tolerance_px = 4.1;
  EXPECT_EQ(score(builder, options).precision, 1.0);
}

TEST(TrackScores, SkyIsUnscored) {
  TableBuilder builder(frames);
  builder.follow(0, 3, 1, 3, -4.5, fresh);                                   // row 5: sky
  builder.see(6, 1, WallGroundTruth::wall_pixel(6, 3, -4.5), reidentified);  // sky again
  const TrackScores scores = score(builder);
  EXPECT_EQ(scores.reidentified, 1);
  EXPECT_EQ(scores.unscored, 1);
  EXPECT_EQ(scores.wrong, 0);
  EXPECT_FALSE(scores.precision.has_value());
  EXPECT_EQ(scores.lost_unscored, 2);
}

TEST(TrackScores, SlippedFeatureIsCountedSeparately) {
  // Tracked on the wall, then dragged onto the board for one frame, then re-identified on the wall.
  TableBuilder builder(frames);
  builder.follow(0, 5, 1, 0, 1, fresh).see(6, 1, WallGroundTruth::wall_pixel(6, 0, 1), tracked);
  builder.see(10, 1, WallGroundTruth::wall_pixel(10, 0, 1), reidentified);
  const TrackScores scores = score(builder);
  EXPECT_EQ(scores.wrong, 1);
  EXPECT_EQ(scores.wrong_but_earlier_position, 1);
}

TEST(TrackScores, IdSwitchesCountJumpsOfTrackedFeaturesToo) {
  TableBuilder builder(frames);
  builder.follow(0, 2, 1, 3, 1, fresh).follow(3, 5, 1, 3.5, 1, tracked);  // a jump of 5 px while tracked
  builder.follow(0, 5, 2, 3, 3, fresh);
  const TrackScores scores = score(builder);
  EXPECT_EQ(scores.id_switches, 1);
  EXPECT_EQ(scores.reidentified, 0);
  EXPECT_NEAR(scores.drift_p95_px.value(), 5.0, 1e-4);
  EXPECT_NEAR(scores.drifted_share, 3.0 / 10.0, 1e-12);
}

TEST(TrackScores, MissesHaveAReason) {
  TableBuilder blocked(frames);
  blocked.follow(0, 5, 1, 0, 1, fresh).follow(0, 19, 2, 0.5, 1.2, fresh);  // 5 px beside it, tracked throughout
  blocked.follow(10, 10, 3, 5, 1, fresh);
  EXPECT_EQ(score(blocked).misses.blocked, 1);

  TableBuilder new_id(frames);
  new_id.follow(0, 5, 1, 0, 1, fresh).follow(10, 19, 3, 0.1, 1, fresh);
  EXPECT_EQ(score(new_id).misses.not_reidentified, 1);

  TableBuilder elsewhere(frames);
  elsewhere.follow(0, 5, 1, 0, 1, fresh).follow(10, 19, 3, 5, 1, fresh);
  EXPECT_EQ(score(elsewhere).misses.never_detected, 1);

  EXPECT_EQ(score(TableBuilder(frames).follow(0, 5, 1, 0, 1, fresh)).misses.budget_full, 1);
}

TEST(TrackScores, FramesOutsideTheRangeDoNotCount) {
  TrackScoreOptions options = small_image_options();
  const TableBuilder builder = TableBuilder(frames).follow(0, 5, 7, 0, 1, fresh).follow(9, 19, 7, 0, 1, reidentified);
  options.end_frame = 10;
  EXPECT_EQ(score(builder, options).recall, 1.0);
  options.end_frame = 9;
  EXPECT_EQ(score(builder, options).lost, 1);
  EXPECT_EQ(score(builder, options).reappeared, 0) << "reappears after the range";
  options.end_frame = frames;
  options.first_frame = 8;
  const TrackScores late = score(builder, options);
  EXPECT_EQ(late.lost, 0) << "lost before the range";
  EXPECT_EQ(late.correct, 1) << "the re-identification is inside, its anchor before the range";
  EXPECT_EQ(late.mean_track_length, 11.0);
}

TEST(TrackScores, LengthsAreObservationsPerId) {
  const TrackScores scores = score(
      TableBuilder(frames).follow(0, 0, 1, 3, 1, fresh).follow(0, 3, 2, 4, 1, fresh).follow(2, 8, 3, 4, 2, fresh));
  EXPECT_EQ(scores.ids, 3);
  EXPECT_EQ(scores.mean_track_length, 4.0);
  EXPECT_EQ(scores.median_track_length, 4.0);
  EXPECT_EQ(scores.length_histogram, (std::vector<std::int64_t>{1, 0, 1, 1, 0, 0, 0, 0}));
}

TEST(TrackScores, MappedTruthScoresEveryOtherFrame) {
  TableBuilder builder(frames / 2);
  std::vector<std::int64_t> chosen;
  for (std::int64_t k = 0; k < frames / 2; ++k) {
    const std::int64_t in_ground_truth = 2 * k;
    chosen.push_back(in_ground_truth);
    const Eigen::Vector2d pixel = WallGroundTruth::wall_pixel(in_ground_truth, 0, 1);
    if (!WallGroundTruth::covered(in_ground_truth, pixel))
      builder.see(k, 1, pixel, k == 5 ? reidentified : k == 0 ? fresh : tracked);
  }
  const WallGroundTruth ground_truth(frames);
  const TrackScores scores =
      score_tracks(builder.table(), MappedGroundTruth(ground_truth, chosen), small_image_options());
  EXPECT_EQ(scores.lost, 1);
  EXPECT_EQ(scores.recall, 1.0);
}

TEST(TrackScores, RefusesInputThatCannotBeScored) {
  const WallGroundTruth ground_truth(frames);
  EXPECT_THROW(score_tracks(TableBuilder(frames + 1).table(), ground_truth), Error);
  EXPECT_THROW(score_tracks(TrackTable{}, ground_truth), Error);
  TrackScoreOptions options;
  options.window = 0;
  EXPECT_THROW(score_tracks(TableBuilder(3).table(), ground_truth, options), Error);
  options = {};
  options.first_frame = 5;
  options.end_frame = 5;
  EXPECT_THROW(score_tracks(TableBuilder(9).table(), ground_truth, options), Error);
  EXPECT_EQ(score_tracks(TableBuilder(9).table(), ground_truth).recall, std::nullopt);
}

/// For any tracker the counts add up and the ratios are between 0 and 1.
TEST(TrackScores, CountsAddUpForAnyTable) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    TableBuilder builder(frames);
    for (std::int64_t k = 0; k < frames; ++k) {
      for (std::int64_t id = 0; id < 8; ++id) {
        if (random.uniform() < 0.4) continue;
        const double noise = random.uniform() < 0.8 ? 0.5 : 40.0;
        const Eigen::Vector2d pixel = WallGroundTruth::wall_pixel(k, -4.0 + static_cast<double>(id), 1.0) +
                                      Eigen::Vector2d(random.normal(), random.normal()) * noise;
        builder.see(k, id, pixel, static_cast<TrackState>(random.below(3)));
      }
    }
    const TrackScores s = score(builder);
    EXPECT_EQ(s.reidentified, s.correct + s.wrong + s.unscored);
    const WrongReasons& w = s.wrongs;
    EXPECT_EQ(s.wrong, w.unknown_id + w.anchor_outside + w.anchor_occluded + w.other_position + w.on_occluder);
    const MissReasons& m = s.misses;
    EXPECT_EQ(s.reappeared - s.recalled,
              m.wrong_position + m.not_reidentified + m.blocked + m.budget_full + m.never_detected);
    EXPECT_LE(s.reappeared, s.lost);
    EXPECT_LE(s.recalled, s.reappeared);
    EXPECT_TRUE(!s.recall || (*s.recall >= 0.0 && *s.recall <= 1.0));
    EXPECT_TRUE(!s.precision || (*s.precision >= 0.0 && *s.precision <= 1.0));
  }
}

}  // namespace
}  // namespace rastro
