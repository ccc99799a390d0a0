// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/score_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "rastro/base/error.h"

namespace rastro {
namespace {

using testing::HasSubstr;

TrackScores some_scores() {
  TrackScores scores;
  scores.recall = 0.75;
  scores.precision = 0.9;
  scores.reappeared = 4;
  scores.recalled = 3;
  scores.misses.blocked = 1;
  scores.correct = 9;
  scores.wrong = 1;
  scores.reidentified = 10;
  scores.wrongs.other_position = 1;
  scores.ids = 2;
  scores.mean_track_length = 2.5;
  scores.median_track_length = 2.5;
  scores.length_histogram = {0, 1, 1, 0, 0, 0, 0, 0};
  FrameScores row;
  row.index = 7;
  row.recalled = 3;
  scores.frames = {row};
  return scores;
}

TEST(ScoreReport, JsonHasTheFiguresAndNullForMissingValues) {
  const auto full = nlohmann::json::parse(scores_as_json(some_scores(), true));
  for (const char* key :
       {"recall", "precision", "lost", "reappeared", "reidentified", "wrong", "id_switches", "mean_track_length"})
    EXPECT_TRUE(full.at(key).is_number()) << key;
  EXPECT_EQ(full["recall"], 0.75);
  EXPECT_EQ(full["length_histogram"]["3-5"], 1);
  EXPECT_EQ(full["frames"][0]["frame"], 7);
  EXPECT_EQ(full["frames"][0]["recalled"], 3);
  const auto empty = nlohmann::json::parse(scores_as_json(TrackScores{}, false));
  for (const char* key : {"recall", "precision", "mean_track_length", "drift_median_px", "unscored_share"})
    EXPECT_TRUE(empty.at(key).is_null()) << key;
  EXPECT_FALSE(empty.contains("frames"));
}

TEST(ScoreReport, TextExplainsAndMarksMissingValues) {
  const std::string text = scores_as_text(some_scores(), false);
  EXPECT_THAT(text, HasSubstr("recall 0.750: 3 of 4"));
  EXPECT_THAT(text, HasSubstr("1 with another feature within"));
  EXPECT_THAT(text, HasSubstr("wrong: 1 = 1 at another position"));
  EXPECT_THAT(scores_as_text(TrackScores{}, true), HasSubstr("recall n/a"));
}

TEST(ScoreReport, CsvHasOneRowPerFrame) {
  const std::string csv = scores_as_csv(some_scores());
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2);
  EXPECT_THAT(csv, HasSubstr("\n7,0,0,0,0,0,0,0,0,0,0,0,0,3\n"));
}

TEST(ScoreReport, LimitsAreParsedAndChecked) {
  const TrackScores scores = some_scores();
  EXPECT_TRUE(keeps_limit(scores, parse_limit("recall>=0.75")));
  EXPECT_FALSE(keeps_limit(scores, parse_limit("recall>=0.76")));
  EXPECT_TRUE(keeps_limit(scores, parse_limit(" wrong <= 1")));
  EXPECT_FALSE(keeps_limit(scores, parse_limit("wrong<=0")));
  EXPECT_FALSE(keeps_limit(TrackScores{}, parse_limit("recall>=0"))) << "nothing to count is not a pass";
}

TEST(ScoreReport, BrokenLimitsAreRefusedInOneLine) {
  for (const char* text : {"", "recall", "recall>0.7", "recall>=", "recall>=x", ">=3", "recall>=nan", "<"})
    EXPECT_THROW(parse_limit(text), Error) << text;
  try {
    parse_limit("recal>=0.7");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("'recall'"));
  }
}

}  // namespace
}  // namespace rastro
