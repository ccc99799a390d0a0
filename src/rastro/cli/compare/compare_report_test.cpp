// SPDX-License-Identifier: Apache-2.0
// What a comparison says of results: table, differences, advice, reports.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <set>

#include "rastro/base/append_file.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/cli/compare/auto_choice.h"
#include "rastro/cli/compare/report_html.h"
#include "rastro/cli/compare/report_tables.h"
#include "rastro/cli/compare/svg_chart.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr int frame_count = 40;

std::string poses(double error_m, int from, int every) {
  std::string text;
  for (int k = from; k < frame_count; ++k)
    text += fmt::format("{:.3f} {:.9f} {:.9f} {:.9f} 0 0 0 1\n", 0.1 * k, 0.1 * k + (k % every == 0 ? error_m : 0.0),
                        std::sin(0.3 * k), 0.02 * k);
  return text;
}

/// A run that tracks frames from `from` on and is off by `error_m` in every third.
FinishedRun run_of(std::size_t input, const std::string& column, std::uint64_t seed, double error_m, int from) {
  FinishedRun run;
  run.what.input = input, run.what.column = column;
  run.seed = seed;
  run.folder = scratch_folder(fmt::format("{}_{}_{}", input, column, seed));
  run.ground_truth = (run.folder / "truth.txt").string();
  write_whole_file(run.ground_truth, poses(0.0, 0, 3));
  write_whole_file(run.folder / "trajectory.txt", poses(error_m, from, 3));
  std::string stats = "frame,stamp_ns,state,reason\n";
  for (int k = 0; k < frame_count; ++k)
    stats += fmt::format("{},{},{},none\n", k, k * 100'000'000LL, k < from ? "initializing" : "tracking");
  write_whole_file(run.folder / "stats.csv", stats);
  run.result.scores.frames = frame_count, run.result.scores.tracked = frame_count - from;
  run.result.scores.ate_m = error_m, run.result.scores.alignment = "se3";
  run.result.scores.figures = {{"frame_ms", 20.0}, {"stage/track_ms", 7.0}, {"drift_percent", 1.0}};
  run.run_command = "rastro slam <a&b> --method " + column;
  run.evaluate_command = "rastro evaluate trajectory";
  return run;
}

/// `good` has a quarter of the error of `poor` on one input with six seeds; `late` the smallest, of two frames in five.
Comparison three_methods() {
  Comparison comparison;
  CompareInput input;
  input.name = "room_1";
  input.seeds = {1, 2, 3, 4, 5, 6};
  input.facts.has_image = input.facts.has_depth = input.facts.has_ground_truth = true;
  input.facts.rate_hz = 10.0;
  comparison.inputs = {input};
  for (const std::uint64_t seed : input.seeds) {
    comparison.runs.push_back(run_of(0, "good", seed, 0.010 + 0.001 * static_cast<double>(seed), 0));
    comparison.runs.push_back(run_of(0, "poor", seed, 0.040 + 0.004 * static_cast<double>(seed), 0));
    comparison.runs.push_back(run_of(0, "late", seed, 0.001, 24));
  }
  comparison.column_kinds = {{"good", "depth"}, {"poor", "depth"}, {"late", "depth"}};
  comparison.planned = comparison.runs.size();
  comparison.table = table_of(comparison.inputs, comparison.runs);
  return comparison;
}

const PairedDifference& between(const std::vector<PairedDifference>& all, const std::string& a, const std::string& b) {
  for (const PairedDifference& each : all)
    if ((each.first == a && each.second == b) || (each.first == b && each.second == a)) return each;
  throw std::runtime_error("no such pair");
}

TEST(ResultTable, MedianAndWorstOverSeeds) {
  const Comparison comparison = three_methods();
  EXPECT_NEAR(comparison.table.median("room_1", "good", "ate_m").value(), 0.0135, 1e-9);
  EXPECT_NEAR(comparison.table.worst("room_1", "good", compare_figure("ate_m")).value(), 0.016, 1e-9);
  EXPECT_NEAR(comparison.table.worst("room_1", "late", compare_figure("completion_percent")).value(), 40.0, 1e-9);
  EXPECT_FALSE(comparison.table.median("room_1", "good", "length_max_m"));
  EXPECT_EQ(comparison.table.samples("room_1", "good", "ate_m").front().command, "rastro evaluate trajectory");
}

TEST(ResultTable, AFailedRunCompletesNothing) {
  Comparison comparison = three_methods();
  comparison.runs.front().result.failure = "crashed by signal 11";
  comparison.table = table_of(comparison.inputs, comparison.runs);
  EXPECT_EQ(comparison.table.values("room_1", "good", "completion_percent").front(), 0.0);
  EXPECT_EQ(comparison.table.values("room_1", "good", "ate_m").size(), 5U);
}

TEST(PairedDifferences, AreOverTheFramesThatBothTracked) {
  const Comparison comparison = three_methods();
  const auto differences = paired_differences(traces_of(comparison), comparison.table.columns());
  const PairedDifference& clear = between(differences, "good", "poor");
  EXPECT_EQ(clear.first, "good");
  EXPECT_EQ(clear.pairs, 6);
  EXPECT_EQ(clear.first_better, 6);
  EXPECT_NEAR(clear.median_ratio, 0.25, 0.01);
  EXPECT_NEAR(clear.p_value, 0.03125, 1e-9);
  EXPECT_NEAR(clear.adjusted_p, 3 * 0.03125, 1e-9) << "three comparisons were made";
  EXPECT_FALSE(clear.differs_in_completion());
  EXPECT_TRUE(between(differences, "good", "late").differs_in_completion());
}

/// `good` gave no path with these seeds.
Comparison good_failing(const std::set<std::uint64_t>& seeds) {
  Comparison comparison = three_methods();
  for (FinishedRun& run : comparison.runs)
    if (run.what.column == "good" && seeds.contains(run.seed)) run.result.failure = "crashed by signal 11";
  comparison.table = table_of(comparison.inputs, comparison.runs);
  return comparison;
}

TEST(PairedDifferences, ARunWithoutAPathIsWorseThanAnyOther) {
  const auto difference = [](const std::set<std::uint64_t>& seeds) {
    const Comparison comparison = good_failing(seeds);
    return between(paired_differences(traces_of(comparison), {"good", "poor"}), "good", "poor");
  };
  const PairedDifference once = difference({1});
  EXPECT_EQ(once.first, "good");
  EXPECT_EQ(once.pairs, 6);
  EXPECT_EQ(once.first_better, 5);
  EXPECT_EQ(once.first_failed, 1);
  EXPECT_GT(once.p_value, 0.4) << "the largest of six ranks is against it";
  EXPECT_EQ(difference_rows({once})[1][6], "1 / 0 of 6");
  const PairedDifference mostly = difference({1, 2, 3, 4});
  EXPECT_EQ(mostly.first, "poor");
  EXPECT_EQ(mostly.first_better, 4);
  EXPECT_EQ(mostly.second_failed, 4);
  EXPECT_EQ(mostly.median_ratio, 0.0);
  EXPECT_EQ(difference_rows({mostly})[1][2], "-");
  EXPECT_THAT(difference_rows({mostly})[1].back(), "may be chance") << "its completion is higher, too";
}

TEST(PairedDifferences, WhereBothFailNothingTellsThemApart) {
  Comparison comparison = good_failing({2});
  for (FinishedRun& run : comparison.runs)
    if (run.what.column == "poor" && run.seed == 2) run.result.failure = "crashed by signal 11";
  const auto all = paired_differences(traces_of(comparison), {"good", "poor"});
  EXPECT_EQ(between(all, "good", "poor").pairs, 5);
  EXPECT_EQ(between(all, "good", "poor").first_better, 5);
  EXPECT_EQ(between(all, "good", "poor").second_failed, 1);
}

/// The runs of `late` with these seeds track the last `common` frames alone.
Comparison late_beginning_with(const std::set<std::uint64_t>& seeds, int common) {
  Comparison comparison = three_methods();
  for (FinishedRun& run : comparison.runs)
    if (run.what.column == "late" && seeds.contains(run.seed))
      run = run_of(0, "late", run.seed, 0.001, frame_count - common);
  comparison.table = table_of(comparison.inputs, comparison.runs);
  return comparison;
}

TEST(PairedDifferences, RunsWithTooFewCommonFramesAreLeftOutAloud) {
  const auto difference_with = [](int common) {
    const Comparison comparison = late_beginning_with({2, 5}, common);
    return between(report_of(comparison).differences, "late", "poor");
  };
  EXPECT_EQ(left_out_text(difference_with(10)), "");
  const PairedDifference difference = difference_with(9);
  EXPECT_EQ(difference.pairs, 4);
  EXPECT_EQ(difference.runs, 6);
  EXPECT_EQ(difference_rows({difference})[1].back(),
            "no ranking: completion differs; 2 of 6 runs left out: too few frames in common");
}

TEST(PairedDifferences, WithoutCommonFramesNothingIsKnownAndTested) {
  const Comparison comparison = late_beginning_with({1, 2, 3, 4, 5, 6}, 9);
  const auto differences = report_of(comparison).differences;
  ASSERT_EQ(differences.size(), 3U);
  EXPECT_NEAR(between(differences, "good", "poor").adjusted_p, 0.03125, 1e-9) << "one comparison was made";
  const TextRows rows = difference_rows(differences);
  EXPECT_THAT(rows[2], ElementsAre("good", "late", "-", "0 of 0", "-", "-", "0 / 0 of 6", "100 / 22",
                                   "no ranking; 6 of 6 runs left out: too few frames in common"));
  EXPECT_EQ(rows[3][0], "poor");
  const std::string next = use_case_advice(comparison, differences)[0].text;
  EXPECT_THAT(next, Not(HasSubstr("times that of late")));
}

TEST(PairedDifferences, FailuresOfRepeatsCancelOut) {
  const Comparison comparison = three_methods();
  std::vector<ColumnTrace> traces = traces_of(comparison);
  std::erase_if(traces, [](const ColumnTrace& each) { return each.seed != 1; });
  const std::vector<ColumnTrace> once = traces;
  for (ColumnTrace each : once) {
    each.repeat = 2;
    each.has_path = each.column != "poor";
    traces.push_back(each);
  }
  for (ColumnTrace& each : traces)
    if (each.repeat == 1 && each.column == "good") each.has_path = false;
  const auto all = paired_differences(traces, {"good", "poor"});
  EXPECT_EQ(between(all, "good", "poor").median_ratio, 1.0);
  EXPECT_EQ(between(all, "good", "poor").p_value, 1.0);
}

TEST(UseCases, NameTheRunsWithoutAPath) {
  const Comparison some = good_failing({1, 2});
  const std::string advice = report_of(some).advice[0].text;
  EXPECT_THAT(advice, HasSubstr("good: of the 3 methods"));
  EXPECT_THAT(advice, HasSubstr("it gave no path in 2 of 6 runs"));
  EXPECT_THAT(advice, HasSubstr("errors and times are of the runs that gave a path"));
  EXPECT_THAT(summary_rows(some)[1], testing::Contains("0.0145 (2 of 6 failed)"));
  EXPECT_THAT(report_as_markdown(report_of(some)), HasSubstr("Runs that failed count in 'complete'"));
  const std::string mostly = report_of(good_failing({1, 2, 3, 4})).advice[0].text;
  EXPECT_THAT(mostly, HasSubstr("poor: of the 2 methods"));
  EXPECT_THAT(mostly, HasSubstr("gave no path in half of their runs or more: good (4 of 6)"));
}

TEST(ResultTable, TheMedianErrorCountsRunsWithoutOne) {
  const auto median_with = [](const std::set<std::uint64_t>& failed) {
    return good_failing(failed).table.median_error("room_1", "good");
  };
  EXPECT_NEAR(median_with({1, 2}).value(), 0.0155, 1e-9) << "0.013 to 0.016 and two that are worse";
  EXPECT_FALSE(median_with({1, 2, 3}));
}

TEST(Reports, SayWhenTimesAreOfSeveralRunsAtOnce) {
  Comparison comparison = three_methods();
  EXPECT_THAT(report_as_markdown(report_of(comparison)), Not(HasSubstr("at once")));
  for (FinishedRun& run : comparison.runs) run.result.jobs = 2;
  const Report report = report_of(comparison);
  EXPECT_THAT(report.advice[0].text, HasSubstr("20.0 ms a frame on this machine with 2 runs at once"));
  for (const std::string& text : {report_as_markdown(report), report_as_latex(report), comparison_as_text(comparison),
                                  report_as_html(report, scratch_path("report"))})
    EXPECT_THAT(text, HasSubstr("Times are of 2 runs at once"));
}

TEST(UseCases, RecommendTheSmallestErrorOfThoseThatComplete) {
  const Comparison comparison = three_methods();
  const Report report = report_of(comparison);
  EXPECT_EQ(report.advice[0].title, "Hand-held depth camera");
  EXPECT_THAT(report.advice[0].text, HasSubstr("good: of the 3 methods"));
  EXPECT_THAT(report.advice[0].text, HasSubstr("100 % of the frames"));
  EXPECT_THAT(report.advice[1].text, HasSubstr("No data for this"));
  EXPECT_THAT(summary_rows(comparison)[1], testing::Contains("good"));
}

/// A second input on which these columns gave no path, and the others did.
Comparison with_failure_of(const std::set<std::string>& columns) {
  Comparison comparison = three_methods();
  CompareInput input = comparison.inputs.front();
  input.name = "room_2";
  comparison.inputs.push_back(input);
  for (const std::string each : {"good", "poor", "late"}) {
    comparison.runs.push_back(run_of(1, each, 1, 0.02, 0));
    if (columns.contains(each)) comparison.runs.back().result.failure = "exit code 2: no";
  }
  comparison.planned = comparison.runs.size();
  comparison.table = table_of(comparison.inputs, comparison.runs);
  return comparison;
}

TEST(UseCases, AMethodThatFailedOnAnInputIsJudgedByItToo) {
  const auto advice = [](const std::set<std::string>& failed) {
    return report_of(with_failure_of(failed)).advice[0].text;
  };
  EXPECT_THAT(advice({"poor"}), HasSubstr("good: of the 3 methods"));
  EXPECT_THAT(advice({"good"}), HasSubstr("poor: of the 3 methods"));
  const std::string none = advice({"good", "poor"});
  EXPECT_THAT(none, HasSubstr("No method for it is both complete and accurate"));
  EXPECT_THAT(none, Not(HasSubstr("of those that track about as many frames")));
}

TEST(Reports, SayWhatTheyAreOfWhenInterrupted) {
  Comparison comparison = three_methods();
  EXPECT_THAT(report_as_markdown(report_of(comparison)), Not(HasSubstr("interrupted")));
  comparison.planned += 3;
  EXPECT_THAT(report_as_markdown(report_of(comparison)), HasSubstr("interrupted: 18 of 21 runs have results"));
}

TEST(PairedDifferences, AnImportIsComparedByFramesWithAPose) {
  Comparison comparison = three_methods();
  std::vector<ColumnTrace> traces = traces_of(comparison);
  for (ColumnTrace& trace : traces) trace.posed_percent = 99.0;
  EXPECT_TRUE(between(paired_differences(traces, {"good", "late"}), "good", "late").differs_in_completion());
  for (ColumnTrace& trace : traces)
    if (trace.column == "late") trace.trace.frames.clear();
  EXPECT_FALSE(between(paired_differences(traces, {"good", "late"}), "good", "late").differs_in_completion());
}

TEST(UseCases, AFirstLookAtFewFramesIsCalledThat) {
  Comparison comparison = three_methods();
  EXPECT_THAT(report_of(comparison).advice[0].text, Not(HasSubstr("first look")));
  for (FinishedRun& run : comparison.runs) run.result.scores.frames = 3;
  EXPECT_THAT(report_of(comparison).advice[0].text, HasSubstr("With 18 frames in all this is a first look"));
}

TEST(UseCases, WhoClaimsEveryFrameAndIsFarOffSetsNoMark) {
  Comparison comparison = three_methods();
  comparison.table = ResultTable();
  const auto add = [&](const std::string& column, double completion, double error_m) {
    comparison.table.add("room_1", column, "completion_percent", {completion, 1, 1, ""});
    comparison.table.add("room_1", column, "ate_m", {error_m, 1, 1, ""});
  };
  add("good", 90.0, 0.01);
  add("poor", 100.0, 0.5);
  add("late", 20.0, 0.001);
  EXPECT_THAT(use_case_advice(comparison, {})[0].text, HasSubstr("good: of the 3"));
  EXPECT_NEAR(mark_on(comparison.table, "room_1", {"good", "poor", "late"}).completion_percent, 90.0, 1e-9);
}

/// `good` claims no meters: its scale is fitted.
Comparison good_up_to_scale() {
  Comparison comparison = three_methods();
  for (FinishedRun& run : comparison.runs)
    if (run.what.column == "good") run.result.scores.alignment = "sim3";
  return comparison;
}

TEST(PairedDifferences, WhatIsAlignedDifferentlyIsNotRanked) {
  const Comparison comparison = good_up_to_scale();
  const auto differences = paired_differences(traces_of(comparison), comparison.table.columns());
  EXPECT_TRUE(between(differences, "good", "poor").differs_in_alignment);
  EXPECT_FALSE(between(differences, "late", "poor").differs_in_alignment);
  EXPECT_THAT(difference_rows({between(differences, "good", "poor")})[1].back(), "no ranking: aligned differently");
}

TEST(UseCases, MetersAreNotRankedWithAFittedScale) {
  Comparison comparison = good_up_to_scale();
  const Report report = report_of(comparison);
  EXPECT_THAT(report.advice[0].text, HasSubstr("poor: of the 2 methods"));
  EXPECT_THAT(report.advice[0].text, HasSubstr("as their error is after fitting the scale: good."));
  EXPECT_THAT(summary_rows(comparison)[1], testing::Contains("poor"));
  for (FinishedRun& run : comparison.runs) run.result.scores.alignment = "sim3";
  const std::string all = report_of(comparison).advice[0].text;
  EXPECT_THAT(all, HasSubstr("good: of the 3 methods"));
  EXPECT_THAT(all, HasSubstr("It is up to scale: its error is after fitting the scale."));
}

TEST(UseCases, ACarIsKnownByItsSpeed) {
  Comparison comparison = three_methods();
  comparison.inputs[0].facts.has_depth = false;
  for (auto& [column, kind] : comparison.column_kinds) kind = "stereo";
  comparison.inputs[0].facts.speed_m_s = 8.0;
  EXPECT_THAT(use_case_advice(comparison, {})[2].text, HasSubstr("good"));
  EXPECT_THAT(use_case_advice(comparison, {})[3].text, HasSubstr("No data"));
  comparison.inputs[0].facts.speed_m_s = 1.0;
  EXPECT_THAT(use_case_advice(comparison, {})[2].text, HasSubstr("No data"));
  EXPECT_THAT(use_case_advice(comparison, {})[3].text, HasSubstr("good"));
}

TEST(Reports, HtmlHoldsEverythingItself) {
  const Comparison comparison = three_methods();
  const std::string html = report_as_html(report_of(comparison), scratch_path("report"));
  EXPECT_THAT(html, HasSubstr("<svg"));
  EXPECT_THAT(html, HasSubstr("no ranking: completion differs"));
  EXPECT_THAT(html, HasSubstr("exact up to 60 pairs"));
  EXPECT_THAT(html, HasSubstr("rastro slam &lt;a&amp;b&gt; --method good"));
  EXPECT_THAT(html, Not(HasSubstr("http")));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
}

TEST(Reports, TextFormatsSayTheSame) {
  Comparison comparison = three_methods();
  comparison.strengths = {
      {0,
       "good",
       "noise",
       {{10.0, "noise=10", 1.0, 1.1, {}, false, "", ""}, {20.0, "noise=20", 0.5, 1.2, {}, true, "loses track", ""}}}};
  const Report report = report_of(comparison);
  EXPECT_THAT(report_as_markdown(report), HasSubstr("| good | 6 | SE3 | 100.0 | 0.0135 (0.0160) |"));
  EXPECT_THAT(report_as_markdown(report), HasSubstr("| noise=10 | noise=20 | loses track, and warns |"));
  EXPECT_THAT(report_as_latex(report), HasSubstr("\\caption{room\\_1"));
  EXPECT_THAT(report_as_latex(report), HasSubstr("good & 6 & SE3 & 100.0 & 0.0135 (0.0160)"));
  EXPECT_THAT(report_as_csv(comparison), HasSubstr("room_1,good,6,1,ate_m,0.016,rastro evaluate trajectory\n"));
  EXPECT_THAT(report_as_csv(comparison), HasSubstr("stage/track_ms,7,"));
}

TEST(AutoChoice, IsBesideTheBestMethodThatIsAlignedAlikeAndTracksAsMuch) {
  Comparison comparison = three_methods();
  EXPECT_TRUE(auto_on_inputs(comparison).empty());
  const auto add = [&](const std::string& column, double error_m) {
    for (const std::uint64_t seed : comparison.inputs[0].seeds)
      comparison.runs.push_back(run_of(0, column, seed, error_m, 0));
  };
  add("auto", 0.027);
  add("up to scale", 0.001);
  for (FinishedRun& run : comparison.runs)
    if (run.what.column == "up to scale") run.result.scores.alignment = "sim3";
  comparison.table = table_of(comparison.inputs, comparison.runs);
  const auto found = auto_on_inputs(comparison);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].best, "good");
  EXPECT_NEAR(found[0].ratio().value_or(0.0), 2.0, 1e-9);
  EXPECT_EQ(auto_rows(found).back(), (std::vector<std::string>{"worst", "", "", "", "2.00", ""}));
  EXPECT_THAT(report_as_markdown(report_of(comparison)), HasSubstr("| room_1 | good | 0.0135 | 0.0270 | 2.00 |"));
  for (const PairedDifference& each : report_of(comparison).differences)
    EXPECT_TRUE(each.first != "auto" && each.second != "auto") << "a copy of a method would count twice";
}

TEST(AutoChoice, LosingTrackOrFailingIsWorseThanAnyRatio) {
  for (const bool fails : {true, false}) {
    Comparison comparison = three_methods();
    for (const std::uint64_t seed : comparison.inputs[0].seeds) {
      comparison.runs.push_back(run_of(0, "auto", seed, 0.001, 24));
      if (fails) comparison.runs.back().result.scores = {}, comparison.runs.back().result.failure = "exit code 2";
    }
    comparison.table = table_of(comparison.inputs, comparison.runs);
    const auto found = auto_on_inputs(comparison);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_FALSE(found[0].ratio());
    EXPECT_EQ(auto_rows(found)[1][3], fails ? "failed" : "0.0010");
    EXPECT_EQ(auto_rows(found).back()[4], "-");
  }
}

TEST(SvgChart, TicksAreRoundAndNothingHasNoChart) {
  EXPECT_THAT(round_ticks(0.0, 10.0), ElementsAre(0.0, 2.0, 4.0, 6.0, 8.0, 10.0));
  EXPECT_EQ(svg_of({"empty", "x", "y", {}, false, false}), "");
  Chart chart{"a < b", "x", "y", {{"line", {0.0, 1.0}, {0.0, std::nan("")}, 1, false, true}}, true, false};
  EXPECT_THAT(svg_of(chart), HasSubstr("a &lt; b"));
  EXPECT_THAT(svg_of(chart), Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace rastro::cli
