// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/cli/command.h"
#include "rastro/cli/former_flags.h"
#include "rastro/cli/limits.h"
#include "rastro/cli/masks.h"
#include "rastro/cli/parse_error.h"
#include "rastro/cli/progress_bar.h"

namespace rastro::cli {
namespace {

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(ProgressLine, HasABarAndTheTimeLeftWhereTheNumberOfFramesIsKnown) {
  OdometryProgress progress;
  progress.done = 30, progress.frames = 120;
  EXPECT_EQ(progress_line(progress, 10.0, 55.4),
            "[######..................] 30/120  25 %  30 s left  3.0 frames/s  55 MB");
  progress.done = 0;
  EXPECT_EQ(progress_line(progress, 0.0, 1.0), "[........................] 0/120   0 %  0.0 frames/s  1 MB");
  progress.done = 130;
  EXPECT_EQ(progress_line(progress, 13.0, 1.0),
            "[########################] 130/120 108 %  0 s left  10.0 frames/s  1 MB");
  for (const auto frames : {std::optional<std::int64_t>(), std::optional<std::int64_t>(0)}) {
    progress.frames = frames;
    EXPECT_EQ(progress_line(progress, 13.0, 1.0), "130 frames  10.0 frames/s  1 MB");
  }
}

TEST(ProgressLine, SaysHowTheLastFrameWent) {
  OdometryUpdate odometry;
  odometry.inliers = 77, odometry.state = OdometryState::weak;
  OdometryProgress progress;
  progress.last = &odometry;
  EXPECT_TRUE(holds(progress_line(progress, 1.0, 1.0), "  77 points  weak  1 MB"));
  odometry.reason = OdometryReason::blurred;
  EXPECT_TRUE(holds(progress_line(progress, 1.0, 1.0), "  77 points  weak (blurred)  1 MB"));
  SlamUpdate update;
  update.state = SlamState::tracking, update.reason = SlamReason::none;
  SlamProgress slam;
  slam.last = &update;
  EXPECT_TRUE(holds(progress_line(slam, 1.0, 1.0), "  tracking  1 MB"));
  slam.loops_closed = 1;
  EXPECT_TRUE(holds(progress_line(slam, 1.0, 1.0), "  tracking  1 loops  1 MB"));
  TrackFrame frame;
  frame.features.resize(12);
  frame.health = TrackHealth::few_corners;
  TrackProgress track;
  track.last = &frame;
  EXPECT_TRUE(holds(progress_line(track, 1.0, 1.0), "  12 features  few corners  1 MB"));
}

TEST(Limits, NameAFigureOfTheResult) {
  const NamedNumbers known = {{"ate_m", 0.25}, {"coverage", 98.0}};
  const auto limits = parse_limits({"ate_m<=0.3", "coverage>=99"}, known, "ate_m<=0.1");
  ASSERT_EQ(limits.size(), 2U);
  EXPECT_EQ(limits[1].name, "coverage");
  EXPECT_TRUE(holds(error_of([&] { parse_limits({"coverge>=95"}, known, "x<=1"); }), "did you mean 'coverage'"));
  EXPECT_EQ(report_missed({limits[0]}, known), done);
  EXPECT_EQ(report_missed(limits, known), limit_missed);
  EXPECT_EQ(report_missed({limits[0]}, {}), limit_missed) << "a figure that there is not";
}

TEST(Limits, JsonHasWholeNumbersWholeAndOthersToSixDecimals) {
  const auto json = nlohmann::json::parse(as_json({{"count", 7.0}, {"share", 1.0 / 3.0}, {"many", 1e15}}));
  EXPECT_TRUE(json.at("count").is_number_integer());
  EXPECT_EQ(json.at("share"), 0.333333);
  EXPECT_TRUE(json.at("many").is_number_float());
}

std::vector<std::string> warnings_of(const std::function<void()>& work) {
  std::vector<std::string> warnings;
  set_log_sink([&](LogLevel, const std::string& line) { warnings.push_back(line); });
  work();
  set_log_sink({});
  return warnings;
}

TEST(FormerFlags, AreReplacedWithAWarningOfTheNewName) {
  const std::vector<const char*> typed = {"rastro", "track", "--pictures", "hall", "--match-picture=1:9", "--quieter"};
  const std::vector<std::string> current = {"rastro", "track", "--images", "hall", "--match-image=1:9", "--quieter"};
  std::vector<std::string> words;
  const auto warnings = warnings_of([&] { words = with_current_flags(static_cast<int>(typed.size()), typed.data()); });
  EXPECT_EQ(words, current);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_TRUE(holds(warnings[0], "--pictures is now --images"));
  EXPECT_TRUE(holds(warnings[1], "--match-picture is now --match-image"));
}

TEST(FormerFlags, BelongToACommandAndEndWithTheFlags) {
  const std::vector<std::vector<const char*>> kept = {{"rastro"},
                                                      {"rastro", "--truth"},
                                                      {"rastro", "export", "--pictures", "--truth=x"},
                                                      {"rastro", "track", "--picturesque", "--", "--pictures"}};
  for (const auto& typed : kept) {
    const auto warnings = warnings_of([&] {
      EXPECT_EQ(with_current_flags(static_cast<int>(typed.size()), typed.data()),
                std::vector<std::string>(typed.begin(), typed.end()));
    });
    EXPECT_TRUE(warnings.empty());
  }
  const char* const quiet[] = {"rastro", "evaluate", "tracks", "run", "--truth", "hall", "--quiet"};
  const auto warnings = warnings_of([&] { EXPECT_EQ(with_current_flags(7, quiet)[4], "--ground-truth"); });
  EXPECT_TRUE(warnings.empty());
}

TEST(ParseErrors, NameTheNearestCommandOrFlag) {
  CLI::App app("", "rastro");
  CLI::App* track = app.add_subcommand("track");
  std::string out;
  track->add_option("--output", out)->required();
  app.add_subcommand("slam");
  const char* const unknown[] = {"rastro", "trak"};
  EXPECT_TRUE(holds(error_of([&] { refuse_unknown_command(app, 2, unknown); }), "did you mean 'track'"));
  const char* const known[] = {"rastro", "slam"};
  EXPECT_NO_THROW(refuse_unknown_command(app, 2, known));
  const char* const flag[] = {"rastro", "--version"};
  EXPECT_NO_THROW(refuse_unknown_command(app, 2, flag));
  EXPECT_NO_THROW(refuse_unknown_command(app, 1, flag));
  const auto line_of = [&](std::vector<const char*> words) -> std::string {
    words.insert(words.begin(), "rastro");
    try {
      app.parse(static_cast<int>(words.size()), words.data());
    } catch (const CLI::ParseError& error) {
      return parse_error_line(app, error);
    }
    return "no error";
  };
  EXPECT_TRUE(holds(line_of({"track", "--outptu=x"}), "unknown option '--outptu' of 'rastro track'"));
  EXPECT_TRUE(holds(line_of({"track", "--outptu=x"}), "did you mean '--output'"));
  const std::string missing = line_of({"track"});
  EXPECT_TRUE(holds(missing, "--output is required; see 'rastro track --help'")) << missing;
  EXPECT_EQ(missing.find('\n'), std::string::npos);
}

/// Three masks of 4 x 3 pixels whose first pixel tells them apart.
std::filesystem::path folder_of_masks(const std::vector<std::string>& names) {
  const std::filesystem::path folder = scratch_folder("masks");
  std::uint8_t value = 10;
  for (const std::string& name : names) {
    write_whole_file(folder / name,
                     "P5\n4 3\n255\n" + std::string(1, static_cast<char>(value++)) + std::string(11, '\xff'));
  }
  return folder;
}

Frame frame_of(std::int64_t index, const std::string& name, int width = 4) {
  Frame frame;
  frame.index = index, frame.name = name;
  frame.image = GrayImage(width, 3);
  return frame;
}

TEST(Masks, GoByTheNameOfTheFrameWhereTheFirstHasOne) {
  Masks masks(folder_of_masks({"b.pgm", "a.pgm", "c.pgm"}));
  EXPECT_EQ(masks.mask_of(frame_of(2, "images/b.jpg")).at(0, 0), 10);
  EXPECT_EQ(masks.mask_of(frame_of(0, "a")).at(0, 0), 11);
  EXPECT_TRUE(holds(error_of([&] { masks.mask_of(frame_of(1, "d")); }), "no mask for frame 'd'"));
}

TEST(Masks, ElseGoByTheNumberOfTheFrame) {
  Masks masks(folder_of_masks({"b.pgm", "a.pgm", "c.pgm"}));
  EXPECT_EQ(masks.mask_of(frame_of(0, "other")).at(0, 0), 11) << "in the order of their names";
  EXPECT_EQ(masks.mask_of(frame_of(2, "a")).at(0, 0), 12) << "once by number, always by number";
  EXPECT_TRUE(holds(error_of([&] { masks.mask_of(frame_of(3, "x")); }), "3 masks, but none for frame 3"));
}

TEST(Masks, OneFileIsForAllAndMustHaveTheSizeOfTheImages) {
  Masks masks(folder_of_masks({"only.pgm"}) / "only.pgm");
  for (const std::int64_t frame : {0, 7}) EXPECT_EQ(masks.mask_of(frame_of(frame, "x")).at(0, 0), 10);
  EXPECT_TRUE(holds(error_of([&] { masks.mask_of(frame_of(0, "x", 5)); }), "the mask is 4x3, but the images are 5x3"));
  EXPECT_TRUE(holds(error_of([] { Masks empty(folder_of_masks({})); }), "no image in this folder"));
  const auto black = folder_of_masks({}) / "black.pgm";
  write_whole_file(black, "P5\n2 1\n255\n" + std::string(2, '\0'));
  std::string warned;
  set_log_sink([&warned](LogLevel, std::string_view text) { warned += text; });
  const Masks all_black(black);
  set_log_sink({});
  EXPECT_TRUE(holds(warned, "the mask is black everywhere"));
}

TEST(EmptyValues, AreRefusedUpToTheEndOfTheFlags) {
  EXPECT_TRUE(holds(error_of([] {
                      refuse_empty_values({"rastro", "track", "--out=", "--quiet"});
                    }),
                    "--out=: has no value"));
  EXPECT_NO_THROW(refuse_empty_values({"rastro", "track", "--out=x", "--set", "window=", "--", "--out="}));
}

}  // namespace
}  // namespace rastro::cli
