// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/clean_scores.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/evaluate/wall_ground_truth_testing.h"

namespace rastro {
namespace {

constexpr auto fresh = TrackState::fresh;
constexpr auto tracked = TrackState::tracked;
constexpr auto reidentified = TrackState::reidentified;
constexpr std::int64_t frames = 20;

/// The board of WallGroundTruth as if it had been drawn onto images of the bare wall.
class BoardCover : public OccluderCover {
 public:
  bool covered(std::int64_t frame, const Eigen::Vector2d& pixel, double radius_px) const override {
    for (const double x : {-radius_px, 0.0, radius_px})
      if (WallGroundTruth::covered(frame, pixel + Eigen::Vector2d(x, 0))) return true;
    return false;
  }
};

TrackScoreOptions small_image_options() {
  TrackScoreOptions options;
  options.image_width = 200;
  options.image_height = 100;
  options.min_distance_px = 8.0;
  options.clearance_px = 3.0;
  return options;
}

TrackScores score(const TableBuilder& occluded, const TableBuilder& clean) {
  const BoardCover cover;
  return score_clean_tracks(occluded.table(), clean.table(), &cover, small_image_options());
}

/// Wall point (0, 1), occluded by the board in frames 6 to 8, tracked throughout without the board.
TableBuilder clean_point() { return TableBuilder(frames).follow(0, 19, 900, 0, 1, fresh); }

TEST(CleanScores, PointThatReappearsIsRecalled) {
  const TrackScores scores =
      score(TableBuilder(frames).follow(0, 5, 1, 0, 1, fresh).follow(9, 19, 1, 0, 1, reidentified), clean_point());
  EXPECT_EQ(scores.lost, 1);
  EXPECT_EQ(scores.frames[6].lost, 1);
  EXPECT_EQ(scores.recall, 1.0);
  EXPECT_EQ(scores.precision, 1.0);
  EXPECT_EQ(scores.id_switches, 0);
}

TEST(CleanScores, PointThatReappearsAsNewIsMissed) {
  const TrackScores scores =
      score(TableBuilder(frames).follow(0, 5, 1, 0, 1, fresh).follow(9, 19, 2, 0, 1, fresh), clean_point());
  EXPECT_EQ(scores.recall, 0.0);
  EXPECT_FALSE(scores.precision.has_value());
  EXPECT_EQ(scores.misses.not_reidentified, 1);
}

TEST(CleanScores, WrongPositionsAndOccludedPositionsAreWrong) {
  TableBuilder builder(frames);
  builder.follow(0, 5, 1, 0, 1, fresh).follow(9, 9, 1, 0.4, 1, reidentified);  // 4 px off
  TrackScores scores = score(builder, clean_point());
  EXPECT_EQ(scores.precision, 0.0);
  EXPECT_EQ(scores.misses.wrong_position, 1);
  EXPECT_EQ(scores.wrongs.other_position, 1);
  scores = score(TableBuilder(frames).follow(0, 5, 1, 0, 1, fresh).follow(7, 7, 1, 0, 1, reidentified), clean_point());
  EXPECT_EQ(scores.wrongs.anchor_occluded, 1);
}

TEST(CleanScores, CounterpartIsTakenWhereTheOccluderWasFar) {
  // Dragged 5 px along with the board in frames 6 and 7, then lost; it belongs to the point it was on in frame 5.
  TableBuilder builder(frames);
  builder.follow(0, 5, 1, 0, 1, fresh);
  for (std::int64_t k = 6; k <= 7; ++k) builder.see(k, 1, WallGroundTruth::wall_pixel(k, 0.5, 1), tracked);
  builder.follow(10, 19, 1, 0, 1, reidentified);
  TableBuilder clean = clean_point();
  clean.follow(0, 19, 901, 0.5, 1, fresh);
  const TrackScores scores = score(builder, clean);
  EXPECT_EQ(scores.precision, 1.0);
  EXPECT_EQ(scores.recall, 1.0);
}

TEST(CleanScores, WithoutCounterpartNothingIsScored) {
  const TableBuilder builder = TableBuilder(frames).follow(0, 5, 1, 0, 1, fresh).follow(9, 19, 1, 0, 1, reidentified);
  TrackScores scores = score(builder, TableBuilder(frames).follow(0, 19, 900, 0.2, 1, fresh));  // 2 px beside it
  EXPECT_EQ(scores.unscored, 1);
  EXPECT_EQ(scores.lost_unscored, 1);
  EXPECT_FALSE(scores.recall.has_value() || scores.precision.has_value());
  // The clean track ends while the position is occluded.
  scores = score(builder, TableBuilder(frames).follow(0, 7, 900, 0, 1, fresh));
  EXPECT_EQ(scores.unscored, 1);
  EXPECT_EQ(scores.lost_unscored, 1);
  EXPECT_EQ(scores.lost, 0);
}

TEST(CleanScores, OnlyTrackedSegmentsAreGroundTruth) {
  const TableBuilder builder = TableBuilder(frames).follow(0, 5, 1, 0, 1, fresh).follow(9, 19, 1, 0, 1, reidentified);
  const TableBuilder broken =
      TableBuilder(frames).follow(0, 6, 900, 0, 1, fresh).follow(7, 19, 900, 0, 1, reidentified);
  EXPECT_EQ(score(builder, broken).unscored, 1);
}

TEST(CleanScores, LossesWhileVisibleAndAtTheEdgeAreNotOcclusion) {
  TableBuilder clean(frames);
  clean.follow(0, 19, 900, 4, 1, fresh).follow(8, 16, 901, -8.6, 1, fresh);
  TableBuilder builder(frames);
  builder.follow(0, 2, 1, 4, 1, fresh).follow(5, 19, 1, 4, 1, reidentified).follow(8, 10, 2, -8.6, 1, fresh);
  const TrackScores scores = score(builder, clean);
  EXPECT_EQ(scores.lost_visible, 1);
  EXPECT_EQ(scores.lost_outside, 1);
  EXPECT_EQ(scores.lost, 0);
  EXPECT_EQ(scores.precision, 1.0);
}

TEST(CleanScores, IdOfTheOccluderOnTheWallIsWrong) {
  TableBuilder builder(frames);
  for (std::int64_t k = 5; k <= 7; ++k)
    builder.see(k, 1, {100 + 20 * (WallGroundTruth::board_left(k) + 1.0 - WallGroundTruth::camera_x(k)), 60},
                k == 5 ? fresh : tracked);
  builder.see(12, 1, WallGroundTruth::wall_pixel(12, 0, 1), reidentified);
  EXPECT_EQ(score(builder, clean_point()).wrong, 1);
}

TEST(CleanScores, CornersOnTheOccluderAreUnscoredAndCountedSeparately) {
  const auto on_board = [](std::int64_t k) {
    return Eigen::Vector2d(100 + 20 * (WallGroundTruth::board_left(k) + 1.0 - WallGroundTruth::camera_x(k)), 60);
  };
  TableBuilder builder(frames);
  builder.see(5, 1, on_board(5), fresh).see(7, 1, on_board(7), reidentified);
  const TrackScores scores = score(builder, clean_point());
  EXPECT_EQ(scores.unscored, 1);
  EXPECT_EQ(scores.unscored_on_occluder, 1);
}

TEST(CleanScores, FramesArePairedByStamp) {
  TrackTable occluded = TableBuilder(frames).follow(0, 5, 1, 0, 1, fresh).follow(9, 19, 1, 0, 1, reidentified).table();
  TrackTable clean = clean_point().table();
  // The clean run has three more frames before.
  clean.frames.insert(clean.frames.begin(), 3, TrackFrame{});
  for (std::int64_t k = 0; k < 3; ++k) clean.frames[static_cast<std::size_t>(k)].stamp = -1000 + k;
  const BoardCover cover;
  EXPECT_EQ(score_clean_tracks(occluded, clean, &cover, small_image_options()).recall, 1.0);
  for (TrackFrame& frame : clean.frames) frame.stamp += 7;
  EXPECT_THROW(score_clean_tracks(occluded, clean, &cover, small_image_options()), Error);
}

TEST(CleanScores, WithoutMasksEveryLossWithATrackedCounterpartCounts) {
  const TableBuilder builder = TableBuilder(frames).follow(0, 5, 1, 0, 1, fresh).follow(9, 19, 1, 0, 1, reidentified);
  const TrackScores scores = score_clean_tracks(builder.table(), clean_point().table(), nullptr, small_image_options());
  EXPECT_EQ(scores.lost, 1);
  EXPECT_EQ(scores.recall, 1.0);
  EXPECT_EQ(scores.precision, 1.0);
}

}  // namespace
}  // namespace rastro
