// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/tracks_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/export/read_tracks.h"
#include "rastro/export/track_frames_testing.h"

namespace rastro {
namespace {

std::string written(const std::vector<TrackFrame>& frames, const std::string& name) {
  const auto folder = scratch_folder("csv_" + name);
  TracksCsv csv(folder / "tracks.csv");
  for (const TrackFrame& frame : frames) csv.write(frame, {});
  csv.finish();
  return read_whole_file(folder / "tracks.csv");
}

std::string message_of(const std::string& text) {
  try {
    parse_tracks_csv(text, "t.csv");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(TracksCsv, ReadsBackWhatItWrote) {
  const auto frames = awkward_frames();
  const TrackTable table = parse_tracks_csv(written(frames, "round_trip"), "t.csv");
  ASSERT_EQ(table.frames.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_TRUE(same_frame(table.frames[i], frames[i])) << "frame " << i;
}

TEST(TracksCsv, FirstRowsAreAsDocumented) {
  EXPECT_EQ(written({make_frame(2, {make_feature(5, TrackState::fresh, 1.5F, 2.0F)}), make_frame(3, {})}, "rows"),
            "frame,stamp_ns,id,x_px,y_px,ray_x,ray_y,age,state,last_seen,frame_features,frame_lost,frame_masked,"
            "frame_health\n"
            "2,1403636579863555584,5,1.5,2,0.15,0.000002,1,new,-1,1,0,0,good\n"
            "3,1403636579913555584,-1,nan,nan,nan,nan,0,none,-1,0,0,0,good\n");
}

TEST(TracksCsv, HashIsThatOfTheBytesWithAndWithoutFile) {
  const auto frames = awkward_frames();
  Sha256 expected;
  expected.add(written(frames, "hash"));
  TracksCsv unwritten(std::nullopt);
  for (const TrackFrame& frame : frames) unwritten.write(frame, {});
  EXPECT_EQ(unwritten.sha256(), expected.finish());
}

TEST(TracksCsv, CutAtAnyByteKeepsTheWholeFrames) {
  const auto frames = awkward_frames();
  const std::string text = written(frames, "cut");
  const std::size_t header = text.find('\n') + 1;
  std::vector<std::size_t> frame_ends;
  for (std::size_t i = 0; i <= frames.size(); ++i) {
    frame_ends.push_back(written({frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(i)}, "cut_part").size());
  }
  for (std::size_t cut = header; cut <= text.size(); ++cut) {
    const TrackTable table = parse_tracks_csv(std::string_view(text).substr(0, cut), "t.csv");
    std::size_t whole = 0;
    while (whole < frames.size() && frame_ends[whole + 1] <= cut) ++whole;
    ASSERT_EQ(table.frames.size(), whole) << "cut at " << cut;
    for (std::size_t i = 0; i < whole; ++i) ASSERT_TRUE(same_frame(table.frames[i], frames[i])) << "cut at " << cut;
  }
}

TEST(TracksCsv, NamesTheLineOfWhatIsWrong) {
  const std::string header = written({}, "header");
  const std::string row = "0,5,0,1,2,nan,nan,1,new,-1,1,0,0,good\n";
  EXPECT_EQ(message_of(header + row), "no error");
  EXPECT_THAT(message_of("a,b\n"), testing::HasSubstr("t.csv:1: does not start with the header"));
  EXPECT_THAT(message_of(header + "0,5\n"), testing::HasSubstr("t.csv:2: 2 columns instead of 14"));
  EXPECT_THAT(message_of(header + row + row), testing::HasSubstr("t.csv:3: frame 0 has more rows"));
  EXPECT_THAT(message_of(header + "x,5,0,1,2,nan,nan,1,new,-1,1,0,0,good\n"), testing::HasSubstr("column 'frame'"));
  EXPECT_THAT(message_of(header + "0,5,0,nan,2,nan,nan,1,new,-1,1,0,0,good\n"), testing::HasSubstr("not a feature"));
  EXPECT_THAT(message_of(header + "0,5,0,1e99,2,nan,nan,1,new,-1,1,0,0,good\n"), testing::HasSubstr("not a feature"));
  EXPECT_THAT(message_of(header + "0,5,0,1,2,nan,nan,1,old,-1,1,0,0,good\n"), testing::HasSubstr("not a feature"));
  EXPECT_THAT(message_of(header + "0,5,0,1,2,nan,nan,1,new,-1,1,0,0,fine\n"), testing::HasSubstr("frame_health"));
  EXPECT_THAT(message_of(header + "0,5,0,1,2,nan,nan,1,new,-1,2,0,0,good\n1" + row.substr(1)),
              testing::HasSubstr("frame 0 has fewer rows"));
  EXPECT_THAT(message_of(header + "0,5,3,1,2,nan,nan,1,new,-1,2,0,0,good\n0,5,3,1,2,nan,nan,1,new,-1,2,0,0,good\n"),
              testing::HasSubstr("t.csv:3: ids are not in ascending order"));
  EXPECT_THAT(message_of(header + "0,5,3,1,2,nan,nan,1,new,-1,2,0,0,good\n0,6,4,1,2,nan,nan,1,new,-1,2,0,0,good\n"),
              testing::HasSubstr("disagree"));
  EXPECT_THAT(message_of(header + "4" + row.substr(1) + row), testing::HasSubstr("not in ascending order"));
}

TEST(ReadTracks, PrefersTheCsvAndSaysWhatIsMissing) {
  const auto folder = scratch_folder("read_tracks");
  EXPECT_THROW(read_tracks(folder), Error);
  EXPECT_THROW(read_tracks(folder / "nothing"), Error);
  { TracksCsv csv(folder / "tracks.csv"); }
  EXPECT_THROW(read_tracks(folder), Error) << "a file without a frame";
  {
    TracksCsv csv(folder / "tracks.csv");
    csv.write(awkward_frames()[0], {});
  }
  EXPECT_EQ(read_tracks(folder).frames.size(), 1U);
  EXPECT_EQ(read_tracks(folder / "tracks.csv").frames.size(), 1U);
}

}  // namespace
}  // namespace rastro
