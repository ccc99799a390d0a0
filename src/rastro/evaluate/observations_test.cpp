// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/observations.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/evaluate/clean_segments.h"
#include "rastro/evaluate/score_limit.h"

namespace rastro {
namespace {

TrackedFeature feature(std::int64_t id, float x, float y, TrackState state = TrackState::tracked) {
  TrackedFeature result;
  result.id = id;
  result.pixel = {x, y};
  result.state = state;
  return result;
}

/// Frames with these features, 100 ns apart.
TrackTable table_of(const std::vector<std::vector<TrackedFeature>>& frames) {
  TrackTable table;
  for (const auto& features : frames) {
    TrackFrame frame;
    frame.index = static_cast<std::int64_t>(table.frames.size());
    frame.stamp = 100 * frame.index;
    frame.features = features;
    table.frames.push_back(frame);
  }
  return table;
}

TEST(IndexTracks, HasEveryObservationOfTheRangeOnceAndTheLastBeforeIt) {
  Random random(3);
  std::vector<std::vector<TrackedFeature>> frames(20);
  for (auto& features : frames)
    for (std::int64_t id = 0; id < 15; ++id)
      if (random.below(3) > 0) features.push_back(feature(id, static_cast<float>(random.uniform(0.0, 600.0)), 5.0F));
  const TrackTable table = table_of(frames);
  TrackScoreOptions options;
  options.first_frame = 6;
  options.end_frame = 15;
  const TrackIndex index = index_tracks(table, options);
  EXPECT_EQ(index.first, 6);
  EXPECT_EQ(index.end, 15);
  EXPECT_EQ(index.duplicate_ids, 0);
  for (std::int64_t id = 0; id < 15; ++id) {
    Track expected;
    std::int64_t before = -1;
    for (std::int64_t k = 0; k < 15; ++k) {
      for (const TrackedFeature& one : table.frames[static_cast<std::size_t>(k)].features) {
        if (one.id == id && k >= 6) expected.push_back({k, one.pixel.cast<double>(), one.state});
        if (one.id == id && k < 6) before = k;
      }
    }
    const Track& track = index.tracks.at(id);
    ASSERT_EQ(track.size(), expected.size()) << id;
    for (std::size_t i = 0; i < track.size(); ++i) {
      EXPECT_EQ(track[i].frame, expected[i].frame);
      EXPECT_EQ(track[i].pixel, expected[i].pixel);
    }
    EXPECT_EQ(index.before.count(id), before < 0 ? 0U : 1U);
    if (before >= 0) {
      EXPECT_EQ(index.before.at(id).frame, before);
    }
  }
}

TEST(IndexTracks, AnIdTwiceInAFrameCountsOnce) {
  const TrackTable table = table_of({{feature(1, 10, 10), feature(1, 50, 50)}, {feature(1, 11, 10)}});
  const TrackIndex index = index_tracks(table, {});
  EXPECT_EQ(index.duplicate_ids, 1);
  ASSERT_EQ(index.tracks.at(1).size(), 2U);
  EXPECT_EQ(index.tracks.at(1)[0].pixel.x(), 10.0) << "the first of the two";
}

TEST(IndexTracks, RefusesInputThatCannotBeScored) {
  const TrackTable table = table_of({{}, {}, {}});
  TrackScoreOptions options;
  EXPECT_NO_THROW(index_tracks(table, options));
  options.first_frame = 3;
  EXPECT_THROW(index_tracks(table, options), Error);
  EXPECT_THROW(index_tracks({}, {}), Error);
  for (const auto& spoil : std::vector<std::function<void(TrackScoreOptions&)>>{
           [](TrackScoreOptions& o) { o.window = 0; }, [](TrackScoreOptions& o) { o.tolerance_px = 0.0; },
           [](TrackScoreOptions& o) { o.border_px = -1.0; }, [](TrackScoreOptions& o) { o.min_distance_px = -0.1; },
           [](TrackScoreOptions& o) { o.first_frame = -1; },
           [](TrackScoreOptions& o) { o.tolerance_px = std::nan(""); }}) {
    TrackScoreOptions spoilt;
    spoil(spoilt);
    EXPECT_THROW(index_tracks(table, spoilt), Error);
  }
}

TEST(Track, LossesAndReidentificationsAreFrameGapsOrMarks) {
  const Track track{{2, {0, 0}, TrackState::fresh},
                    {3, {0, 0}, TrackState::tracked},
                    {6, {0, 0}, TrackState::tracked},
                    {7, {0, 0}, TrackState::reidentified}};
  const bool returned[] = {false, false, true, true}, ends[] = {false, true, false, true};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(is_reidentification(track, k), returned[k]) << k;
    EXPECT_EQ(ends_at(track, k), ends[k]) << k;
  }
}

TEST(NearImageEdge, IsWithinTheBorderOfAKnownImage) {
  TrackScoreOptions options;
  EXPECT_FALSE(near_image_edge({0.0, 0.0}, options)) << "its size is not known";
  options.image_width = 640;
  options.image_height = 480;
  options.border_px = 10.0;
  for (const auto& [x, y] : {std::pair{10.0, 10.0}, {629.0, 469.0}, {320.0, 240.0}})
    EXPECT_FALSE(near_image_edge({x, y}, options)) << x;
  for (const auto& [x, y] : {std::pair{9.9, 240.0}, {320.0, 9.9}, {629.1, 240.0}, {320.0, 469.1}, {-5.0, 240.0}})
    EXPECT_TRUE(near_image_edge({x, y}, options)) << x;
}

TEST(FrameRows, HaveTheCountsOfTheTracker) {
  const TrackTable table = table_of({{feature(9, 1, 1)},
                                     {feature(0, 1, 1), feature(1, 2, 2, TrackState::fresh)},
                                     {feature(2, 1, 1, TrackState::reidentified)}});
  TrackScoreOptions options;
  options.first_frame = 1;
  const std::vector<FrameScores> rows = frame_rows(table, index_tracks(table, options));
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].index, 1);
  EXPECT_EQ(rows[0].features, 2);
  EXPECT_EQ(rows[0].tracked, 1);
  EXPECT_EQ(rows[0].fresh, 1);
  EXPECT_EQ(rows[1].features, 1);
  EXPECT_EQ(rows[1].tracked + rows[1].fresh, 0);
}

/// One miss each: the reason is the first that holds.
TEST(BookMiss, GivesTheReason) {
  TrackScoreOptions options;
  options.tolerance_px = 3.0;
  options.min_distance_px = 30.0;
  const Eigen::Vector2d position(100.0, 100.0);
  const auto booked = [&](const std::vector<TrackedFeature>& features, std::optional<std::int64_t> back = {}) {
    MissReasons reasons;
    book_miss(table_of({features}), {{0, position}}, back, options, reasons);
    EXPECT_EQ(reasons.wrong_position + reasons.not_reidentified + reasons.blocked + reasons.budget_full +
                  reasons.never_detected,
              1);
    return reasons;
  };
  EXPECT_EQ(booked({}, 0).wrong_position, 1);
  EXPECT_EQ(booked({feature(5, 102, 100, TrackState::fresh)}).not_reidentified, 1);
  EXPECT_EQ(booked({feature(5, 120, 100)}).blocked, 1) << "a tracked feature has the position";
  EXPECT_EQ(booked({feature(5, 200, 100)}).budget_full, 1) << "nothing was detected at all";
  EXPECT_EQ(booked({feature(5, 200, 100, TrackState::fresh)}).never_detected, 1);
}

TEST(FinishScores, SumsRowsAndCountsLengths) {
  std::vector<std::vector<TrackedFeature>> frames(12);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].push_back(feature(0, 1, 1));
    if (k < 5) frames[k].push_back(feature(1, 2, 2));
    if (k < 2) frames[k].push_back(feature(2, 3, 3));
    if (k < 1) frames[k].push_back(feature(3, 4, 4));
  }
  const TrackIndex index = index_tracks(table_of(frames), {});
  TrackScores scores;
  scores.frames.resize(3);
  for (FrameScores& row : scores.frames)
    row.reappeared = 4, row.recalled = 3, row.correct = 5, row.wrong = 1, row.lost = 7;
  finish_scores(index, scores);
  EXPECT_EQ(scores.lost, 21);
  EXPECT_EQ(scores.frame_count, 3);
  EXPECT_NEAR(*scores.recall, 0.75, 1e-12);
  EXPECT_NEAR(*scores.precision, 5.0 / 6.0, 1e-12);
  EXPECT_EQ(scores.ids, 4);
  EXPECT_NEAR(*scores.mean_track_length, (12 + 5 + 2 + 1) / 4.0, 1e-12);
  EXPECT_NEAR(*scores.median_track_length, 3.5, 1e-12) << "between 2 and 5";
  // Bins from 1, 2, 3, 6, 11, ...
  EXPECT_EQ(scores.length_histogram, (std::vector<std::int64_t>{1, 1, 1, 0, 1, 0, 0, 0}));
  TrackScores none;
  finish_scores(TrackIndex(), none);
  EXPECT_FALSE(none.recall || none.precision || none.mean_track_length) << "nothing to count has no value";
}

/// Against a search over every segment; only some frames' stamps are common to both runs.
TEST(CleanSegments, NearestEqualsBruteForce) {
  Random random(17);
  std::vector<std::vector<TrackedFeature>> frames(30);
  for (auto& features : frames) {
    for (std::int64_t id = 0; id < 12; ++id) {
      if (random.below(6) == 0) continue;
      const auto state = random.below(7) == 0 ? TrackState::reidentified : TrackState::tracked;
      features.push_back(feature(id, static_cast<float>(random.uniform(0.0, 100.0)),
                                 static_cast<float>(random.uniform(0.0, 100.0)), state));
    }
  }
  const TrackTable clean = table_of(frames);
  TrackTable occluded = clean;
  for (std::size_t k : {4U, 5U, 17U}) occluded.frames[k].stamp += 1;
  const CleanSegments segments(occluded, clean);
  EXPECT_EQ(segments.shared_frames(), 27);
  int found = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (int trial = 0; trial < 10; ++trial) {
      const Eigen::Vector2d pixel(random.uniform(0.0, 100.0), random.uniform(0.0, 100.0));
      double best = 12.0;
      bool any = false;
      for (const TrackedFeature& one : frames[k]) {
        const double distance = (one.pixel.cast<double>() - pixel).norm();
        if (k == 4 || k == 5 || k == 17 || distance > best) continue;
        best = distance, any = true;
      }
      const CleanSegment* nearest = segments.nearest(static_cast<std::int64_t>(k), pixel, 12.0);
      ASSERT_EQ(nearest != nullptr, any) << k;
      if (!any) continue;
      ++found;
      EXPECT_NEAR((*nearest->at(static_cast<std::int64_t>(k)) - pixel).norm(), best, 1e-12);
    }
  }
  EXPECT_GT(found, 50);
}

TEST(CleanSegments, ASegmentEndsWithFlowAndWithCommonFrames) {
  const auto segment_at = [](const CleanSegments& segments, std::int64_t frame) {
    const CleanSegment* segment = segments.nearest(frame, {10.0, 10.0}, 5.0);
    return segment == nullptr ? std::pair<std::int64_t, std::int64_t>{-1, -1}
                              : std::pair{segment->first, segment->last()};
  };
  TrackTable clean = table_of(std::vector<std::vector<TrackedFeature>>(8, {feature(1, 10, 10)}));
  clean.frames[3].features[0].state = TrackState::reidentified;
  const CleanSegments by_flow(clean, clean);
  EXPECT_EQ(segment_at(by_flow, 2), std::pair(std::int64_t{0}, std::int64_t{2}));
  EXPECT_EQ(segment_at(by_flow, 7), std::pair(std::int64_t{3}, std::int64_t{7}));
  TrackTable occluded = clean;
  occluded.frames[6].stamp += 7;
  const CleanSegments by_stamp(occluded, clean);
  EXPECT_EQ(segment_at(by_stamp, 4), std::pair(std::int64_t{3}, std::int64_t{5}));
  EXPECT_EQ(segment_at(by_stamp, 6), std::pair(std::int64_t{-1}, std::int64_t{-1}));
  EXPECT_EQ(segment_at(by_stamp, 7), std::pair(std::int64_t{7}, std::int64_t{7}));
  for (TrackFrame& frame : occluded.frames) frame.stamp += 50;
  EXPECT_THROW(CleanSegments(occluded, clean), Error);
}

TEST(ScoreLimit, ParsesAndCompares) {
  const ScoreLimit recall = read_limit("recall>=0.7", "x"), error = read_limit(" ate_rmse <= 3e-1", "x");
  EXPECT_EQ(recall.name, "recall");
  EXPECT_TRUE(recall.at_least);
  EXPECT_EQ(error.name, "ate_rmse");
  EXPECT_FALSE(error.at_least);
  EXPECT_EQ(error.value, 0.3);
  for (const auto& [score, kept] : {std::pair{0.69, false}, {0.7, true}, {0.71, true}})
    EXPECT_EQ(keeps_limit(score, recall), kept) << score;
  for (const auto& [score, kept] : {std::pair{0.29, true}, {0.3, true}, {0.31, false}})
    EXPECT_EQ(keeps_limit(score, error), kept) << score;
  EXPECT_FALSE(keeps_limit(std::nullopt, recall));
  EXPECT_FALSE(keeps_limit(std::nullopt, error)) << "a missing value is never within a limit";
  EXPECT_FALSE(keeps_limit(std::nan(""), recall));
}

TEST(ScoreLimit, RefusesOthersWithAnExample) {
  for (const char* text : {"", "recall", "recall>0.7", "recall=0.7", "recall>=", "recall>=much", "recall>=nan", "<"}) {
    try {
      read_limit(text, "recall>=0.5");
      FAIL() << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("recall>=0.5"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace rastro
