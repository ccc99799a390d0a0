// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/benchmark_table.h"

#include <gmock/gmock.h>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"

namespace rastro::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

BenchmarkResult result_of(const std::string& entry, std::uint64_t seed, double ate_m) {
  BenchmarkResult result;
  result.entry = entry, result.seed = seed;
  result.scores.frames = 100, result.scores.tracked = 90;
  result.scores.ate_m = ate_m;
  result.wall_s = 2.0, result.cpu_s = 3.0, result.peak_memory_mb = 150.0;
  return result;
}

const BenchmarkList& two_entries() {
  static const BenchmarkList list = parse_benchmark_list(
      "entries:\n  - {name: walk, world: loop, seeds: [1, 2, 3], method: orb}\n"
      "  - {name: wrong, world: loop, seeds: [1], method: orb, disturb: baseline=10}\n",
      "list.yaml");
  return list;
}

std::vector<BenchmarkResult> three_walks() {
  return {result_of("walk", 1, 0.01), result_of("walk", 2, 0.30), result_of("walk", 3, 0.02)};
}

TEST(BenchmarkTable, RowsHaveMedianWorstSharesAndTimes) {
  auto results = three_walks();
  results[1].scores.false_poses = 4, results[2].scores.false_poses_lost = 2;
  results[2].peak_memory_mb = 200.0;
  results[0].scores.inside_position_percent = 90.0, results[0].scores.inside_rotation_percent = 95.0;
  results[1].scores.inside_position_percent = 100.0, results[1].scores.inside_rotation_percent = 97.0;
  const BenchmarkRows rows = rows_of(two_entries(), results);
  ASSERT_EQ(rows.size(), 2U);
  const BenchmarkRow& row = rows.front();
  EXPECT_EQ(row.runs, 3);
  EXPECT_DOUBLE_EQ(*row.median_ate_m, 0.02);
  EXPECT_DOUBLE_EQ(*row.worst_ate_m, 0.30);
  EXPECT_DOUBLE_EQ(row.tracked_percent, 90.0);
  EXPECT_DOUBLE_EQ(row.inside_position_percent.value(), 95.0) << "the third run gives no covariances";
  EXPECT_DOUBLE_EQ(row.inside_rotation_percent.value(), 96.0);
  EXPECT_THAT(table_text(rows, {}), HasSubstr("95/96"));
  EXPECT_EQ(row.false_poses, 4);
  EXPECT_EQ(row.false_poses_lost, 2);
  EXPECT_DOUBLE_EQ(row.ms_per_frame, 20.0);
  EXPECT_DOUBLE_EQ(row.cpu_ms_per_frame, 30.0);
  EXPECT_DOUBLE_EQ(row.peak_memory_mb, 200.0);
  EXPECT_EQ(rows[1].runs, 0);
  EXPECT_EQ(rows[1].planned, 1);
  EXPECT_EQ(rows[1].warning_due, WarningDue::yes);
  EXPECT_EQ(row.warning_due, WarningDue::no);
}

TEST(BenchmarkTable, TextHasFormerValuesBesideThoseThatChanged) {
  const BenchmarkRows before = rows_of(two_entries(), three_walks());
  auto results = three_walks();
  results[1].scores.ate_m = 0.40;
  const std::string text = table_text(rows_of(two_entries(), results), before);
  EXPECT_THAT(text, HasSubstr("worst m"));
  EXPECT_THAT(text, HasSubstr("0.4000 (0.3000)"));
  EXPECT_THAT(text, Not(HasSubstr("0.0200 (")));
  EXPECT_THAT(text, HasSubstr("0/1")) << "a run is missing";
}

TEST(BenchmarkTable, FailuresAreSaidBelow) {
  auto results = three_walks();
  results[0].failure = "exit code 3: internal error", results[0].scores = {};
  EXPECT_THAT(table_text(rows_of(two_entries(), results), {}),
              HasSubstr("walk: 1 of 3 runs failed; the first: exit code 3: internal error"));
}

TEST(BenchmarkTable, SavedRowsAreReadBack) {
  const auto file = scratch_path("baseline.json");
  const BenchmarkRows rows = rows_of(two_entries(), three_walks());
  write_whole_file(file, to_json(rows));
  const BenchmarkRows read = read_benchmark_rows(file);
  EXPECT_EQ(to_json(read), to_json(rows));
  write_whole_file(file, "{}");
  EXPECT_THROW(read_benchmark_rows(file), Error);
  write_whole_file(file, "no JSON");
  EXPECT_THROW(read_benchmark_rows(file), Error);
}

std::vector<std::string> worse_with(const std::function<void(BenchmarkRow&)>& change) {
  const BenchmarkRows before = rows_of(two_entries(), three_walks());
  BenchmarkRows rows = before;
  change(rows.front());
  return worse_than(rows, before, {});
}

TEST(BenchmarkComparison, NothingIsWorseThanItself) {
  EXPECT_THAT(worse_with([](BenchmarkRow&) {}), IsEmpty());
}

TEST(BenchmarkComparison, ToleranceHoldsForEachValue) {
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.worst_ate_m = 0.315; }), IsEmpty());
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.worst_ate_m = 0.317; }),
              ElementsAre("walk: worst ATE 0.3170 m, was 0.3000 m"));
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.worst_ate_m = 0.1; }), IsEmpty()) << "better is not worse";
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.tracked_percent = 89.5; }), IsEmpty());
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.tracked_percent = 80.0; }),
              ElementsAre("walk: untracked 20.0 %, was 10.0 %"));
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.false_poses_lost = 1; }),
              ElementsAre("walk: false poses 1, was 0"));
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.cpu_ms_per_frame = 33.9; }), IsEmpty());
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.cpu_ms_per_frame = 40.0; }),
              ElementsAre("walk: CPU time per frame 40.0 ms, was 30.0 ms"));
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.peak_memory_mb = 190.0; }),
              ElementsAre("walk: memory 190 MB, was 150 MB"));
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.failed = 1; }), ElementsAre("walk: failed runs 1, was 0"));
}

TEST(BenchmarkComparison, WarningsAreRightOfWrongInputOnly) {
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.warned = 1; }), ElementsAre("walk: false alarms 1, was 0"));
  BenchmarkRow was, is;
  was.name = is.name = "wrong", was.warning_due = is.warning_due = WarningDue::yes, was.runs = is.runs = 1;
  was.warned = 1;
  EXPECT_THAT(worse_than({is}, {was}, {}), ElementsAre("wrong: runs without a warning 1, was 0"));
  EXPECT_THAT(worse_than({was}, {is}, {}), IsEmpty());
  BenchmarkRow right;
  right.runs = 4, right.warned = 1;
  EXPECT_EQ(warnings_text({was, right}),
            "warnings: 1 of 1 runs with wrong input; 1 of 4 with right input (false alarms)\n");
}

TEST(BenchmarkComparison, UnfinishedAndNewEntriesAreNotJudged) {
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.runs = 2, row.worst_ate_m = 9.0; }), IsEmpty());
  EXPECT_THAT(worse_with([](BenchmarkRow& row) { row.name = "new", row.worst_ate_m = 9.0; }), IsEmpty());
}

TEST(BenchmarkTable, CountsWhatIsCompared) {
  BenchmarkRow complete, partial, other;
  complete.name = "complete", complete.runs = complete.planned = 2;
  partial.name = "partial", partial.runs = 1, partial.planned = 2;
  other.name = "other", other.runs = other.planned = 1;
  EXPECT_EQ(compared_with({complete, partial, other}, {complete, partial}), 1);
  EXPECT_EQ(compared_with({complete}, {other}), 0);
}

TEST(BenchmarkTable, ExpectationsOfLocalizationAreCounted) {
  const auto list = parse_benchmark_list(
      "entries:\n  - {name: here, data: a, method: orb, map: {}, expect: found}\n"
      "  - {name: elsewhere, data: a, method: orb, map: {data: b}, expect: lost}\n",
      "list.yaml");
  auto here = result_of("here", 0, 0.01), elsewhere = result_of("elsewhere", 0, 0.01);
  here.scores.posed = 100;
  elsewhere.scores.false_poses = 3;
  EXPECT_THAT(
      expectations_text(list, {here, elsewhere}),
      HasSubstr(
          "1 of 1 runs found the place (a pose for 95 % of the frames, none false); 0 of 1 without the place gave no "
          "false pose; 3 false poses"));
  EXPECT_EQ(expectations_text(two_entries(), three_walks()), "");
}

}  // namespace
}  // namespace rastro::cli
