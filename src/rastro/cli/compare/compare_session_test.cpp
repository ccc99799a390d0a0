// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/compare_session.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "rastro/base/append_file.h"
#include "rastro/base/scratch_testing.h"

namespace rastro::cli {
namespace {

using testing::HasSubstr;

/// Three images.
std::string gray_images(const std::string& name) {
  constexpr int width = 320, height = 240;
  const auto folder = scratch_folder(name);
  for (int frame = 0; frame < 3; ++frame)
    write_whole_file(folder / fmt::format("{}.pgm", frame),
                     fmt::format("P5\n{} {}\n255\n", width, height) + std::string(width * height, 'x'));
  return folder.string();
}

/// Takes every command; how many were disturbed.
BenchmarkTools tools_that_count(int& plain, int& disturbed) {
  BenchmarkTools tools;
  tools.run = [&](const std::vector<std::string>& words) {
    ++(std::find(words.begin(), words.end(), "--disturb") == words.end() ? plain : disturbed);
    ChildEnd end;
    end.exit_code = 0;
    return end;
  };
  tools.score = [](const auto&, const auto&, const auto&) {
    RunScores scores;
    scores.frames = scores.tracked = 3;
    return scores;
  };
  return tools;
}

TEST(CompareSession, ForceRunsWhatIsDisturbedAgainToo) {
  CompareTask task;
  task.inputs = parse_compare_inputs({gray_images("session") + " --intrinsics 300,300,160,120"}, {});
  task.methods = methods_named({"odometry/profiles"});
  task.quiet = true;
  BenchmarkSetup setup;
  setup.out = scratch_folder("compared");
  int plain = 0, disturbed = 0;
  for (const bool force : {false, false, true}) {
    setup.force = force;
    CompareSession session(task, setup, tools_that_count(plain, disturbed), "");
    EXPECT_TRUE(session.run());
    session.add_disturbed(0, task.methods.front(), "noise=10");
    EXPECT_TRUE(session.run());
    EXPECT_EQ(plain, force ? 2 : 1);
    EXPECT_EQ(disturbed, force ? 2 : 1);
  }
}

TEST(CompareSession, CommandsCanBeTypedWherePathsHaveSpaces) {
  CompareTask task;
  task.inputs = parse_compare_inputs({gray_images("my session") + " --intrinsics 300,300,160,120"}, {});
  task.methods = methods_named({"odometry/profiles"});
  task.quiet = true;
  BenchmarkSetup setup;
  setup.out = scratch_folder("my comparison");
  int plain = 0, disturbed = 0;
  BenchmarkTools tools = tools_that_count(plain, disturbed);
  tools.score = [](const auto&, const auto&, const auto&) {
    RunScores scores;
    scores.frames = scores.tracked = 3;
    scores.ate_m = 0.01, scores.alignment = "se3";
    scores.figures = {{"surface_median_m", 0.01}, {"length_max_m", 0.01}};
    return scores;
  };
  CompareSession session(task, setup, tools, "");
  ASSERT_TRUE(session.run());
  const Comparison comparison = session.comparison();
  ASSERT_EQ(comparison.runs.size(), 1U);
  const std::string folder = comparison.runs[0].folder.string(), input = comparison.inputs[0].name;
  const std::string recording = comparison.inputs[0].input.data;
  EXPECT_THAT(comparison.runs[0].run_command, HasSubstr("'" + recording + "'"));
  EXPECT_THAT(comparison.runs[0].run_command, HasSubstr("--out '" + folder + "'"));
  EXPECT_THAT(comparison.runs[0].evaluate_command, HasSubstr(" '" + folder + "' --align se3"));
  const auto command_of = [&](const char* figure) {
    return comparison.table.samples(input, comparison.runs[0].what.column, figure).front().command;
  };
  EXPECT_THAT(command_of("surface_median_m"),
              HasSubstr("rastro evaluate cloud '" + recording + "/truth.ply' '" + folder));
  EXPECT_THAT(command_of("length_max_m"), HasSubstr("--objects '" + recording + "/objects.yaml'"));
}

}  // namespace
}  // namespace rastro::cli
