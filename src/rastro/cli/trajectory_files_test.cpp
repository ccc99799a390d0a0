// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/trajectory_files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/cli/compare/imports.h"

namespace rastro::cli {
namespace {

using ::testing::HasSubstr;

constexpr int frames = 20;

/// A curve that is no line, as rows of a KITTI file, from frame `first` on.
std::string kitti_rows(int first, int end) {
  std::string rows;
  for (int k = first; k < end; ++k) rows += fmt::format("1 0 0 {} 0 1 0 0 0 0 1 {}\n", 0.1 * k, 0.01 * k * k);
  return rows;
}

/// KITTI odometry as it is published: the poses lie beside the sequences, their stamps in the sequence.
std::string published_layout(const std::string& name) {
  const auto folder = scratch_folder(name), sequence = folder / "sequences" / "00";
  std::filesystem::create_directories(sequence / "image_0");
  std::filesystem::create_directories(folder / "poses");
  std::string times;
  for (int k = 0; k < frames; ++k) {
    write_whole_file(sequence / "image_0" / fmt::format("{:06}.pgm", k), "P5\n2 1\n255\n" + std::string(2, 'x'));
    times += fmt::format("{:e}\n", 0.1 * k);
  }
  write_whole_file(sequence / "times.txt", times);
  write_whole_file(folder / "poses" / "00.txt", kitti_rows(0, frames));
  return sequence.string();
}

std::string error_of_action(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ReadReference, KittiPosesGetTheStampsOfTheirSequence) {
  const ReferenceTrajectory reference = read_reference(published_layout("kitti_stamps"), {});
  ASSERT_TRUE(reference.input.has_stamps);
  ASSERT_EQ(reference.input.poses.size(), std::size_t{frames});
  EXPECT_EQ(reference.input.poses[7].stamp, 700'000'000);
  EXPECT_DOUBLE_EQ(reference.input.matrices[7](0, 3), 0.7) << "with all digits of the file";
}

TEST(ReadReference, MayBeOfSomeFramesOnly) {
  const std::string recording = published_layout("kitti_some");
  TrajectoryFileFlags flags;
  flags.frames = "5:9";
  const ReferenceTrajectory reference = read_reference(recording, flags);
  ASSERT_EQ(reference.input.poses.size(), 4U);
  EXPECT_EQ(reference.input.poses.front().stamp, 500'000'000);
  EXPECT_THAT(reference.frames, HasSubstr("4 of 20"));
  flags.frames = "9:5";
  EXPECT_THAT(error_of_action([&] { read_reference(recording, flags); }), HasSubstr("--frames"));
}

class ScoredImports : public ::testing::Test {
 protected:
  ScoredImports() {
    CompareInput input;
    input.name = "00";
    input.input.data = published_layout("kitti_imports");
    input.input.frames = "5:15";
    recordings_ = {input.input.data};
    inputs_ = {input};
    write_whole_file(folder_ / "theirs.txt", kitti_rows(5, 15));
    write_whole_file(folder_ / "whole.txt", kitti_rows(0, frames));
  }

  Import import_of(const std::string& name, const std::string& file) const {
    return parse_import(name + "=" + (folder_ / file).string());
  }
  std::string refusal(const std::vector<Import>& imports) const {
    return error_of_action([&] { score_imports(imports, inputs_, recordings_, {"orb mono"}); });
  }

  std::filesystem::path folder_ = scratch_folder("kitti_theirs");
  std::vector<CompareInput> inputs_;
  std::vector<std::string> recordings_;
};

TEST_F(ScoredImports, AreOfTheFramesOfTheInput) {
  const auto scored = score_imports({import_of("theirs", "theirs.txt")}, inputs_, recordings_, {"orb mono"});
  ASSERT_EQ(scored.size(), 1U);
  EXPECT_NEAR(scored.front().figures.at("ate_m"), 0.0, 1e-6);
  EXPECT_NEAR(scored.front().figures.at("completion_percent"), 100.0, 1e-9);
  EXPECT_THAT(scored.front().what.command, HasSubstr("--frames 5:15"));
}

TEST_F(ScoredImports, WithoutStampsMustHaveAPoseForEachFrame) {
  EXPECT_THAT(refusal({import_of("whole", "whole.txt")}), HasSubstr("20 poses without timestamps for 10"));
}

TEST_F(ScoredImports, HaveNamesOfTheirOwn) {
  EXPECT_THAT(refusal({import_of("orb mono", "theirs.txt")}), HasSubstr("name of another column"));
  const Import theirs = import_of("theirs", "theirs.txt");
  EXPECT_THAT(refusal({theirs, theirs}), HasSubstr("name of another column"));
}

}  // namespace
}  // namespace rastro::cli
