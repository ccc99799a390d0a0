// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/cli/command.h"
#include "rastro/cli/compare/compare_flags.h"
#include "rastro/cli/compare/compare_session.h"
#include "rastro/cli/compare/imports.h"
#include "rastro/cli/compare/map_figures.h"
#include "rastro/cli/compare/map_pages.h"
#include "rastro/cli/compare/paper_front_end.h"
#include "rastro/cli/compare/paper_tables.h"
#include "rastro/cli/compare/report_html.h"
#include "rastro/cli/compare/report_tables.h"
#include "rastro/cli/compare/report_text.h"
#include "rastro/cli/compare/strengths.h"
#include "rastro/cli/interrupt.h"
#include "rastro/cli/program.h"

namespace rastro::cli {
namespace {

constexpr const char* compare_footer = R"(
INPUT is a recording or a world of 'rastro simulate', alone or quoted with flags behind it: those of a world are for 'rastro simulate', those
of a recording for every run on it. --frames of a world is a number, or A:B: B frames are simulated, the runs read A to B-1.
The bare name of a world is the world; ./NAME is a folder of that name. Methods run with every sensor that they can use: a recording with depth also as one of one camera ('orb mono' beside 'orb rgbd'), and as laser scans cut out of the depth
images, as if the camera were level ('hector scan').
A list of 'rastro benchmark' says itself which methods run on what: flags that say so are refused beside it.
--methods takes NAME, odometry/NAME, and NAME:SENSOR, such as orb:stereo.

--import adds the trajectory of another program (TUM, KITTI or EuRoC format), scored as ours: aligned by se3, or sim3 for one camera;
its cloud is compared with the surfaces of generated rooms after the same alignment. @INPUT says of which of several inputs it is.
Poses of another program are taken as the camera's; with 'body' they are of the body (EuRoC: the IMU). Complete is, of an import, the
share of the input's frames with a pose; false are frames whose pose is more than 0.1 m off, where a list of runs does not say otherwise.
--disturb makes the input wrong, stronger from run to run, until a method tracks less than 90 % of the frames that it tracked
without, or its error doubles.

Each run is a process of this program. Its result is one file in --out/results; interrupted with Ctrl-C, the same command goes on
where it was. Results of another program, of other flags, or of files that changed since are run again. --out gets report.html, a page
that needs no network, report.md, report.tex (booktabs) and report.csv, a line for each value with its command, and maps/, a page with the
map of each method in 3D.

Examples:
  rastro compare bedroom --methods all --out compared
  rastro compare tum_fr1_rpy_clip 'kitchen_rgbd --intrinsics 585,585,320,240' --methods orb,rgbd,rtabmap --out compared
  rastro compare 'loop --stereo --frames 300' --methods orb,lsd --seeds 5 --repeat 3 --jobs 2 --out compared
  rastro compare bench/lists/quick.yaml --jobs 2 --out quick
  rastro compare --paper --jobs 2 --out paper
  rastro compare tum_fr1_rpy_clip --methods orb:rgbd --import theirs=theirs.txt --disturb noise,dark --out compared
)";

std::string disturbances_text() {
  std::string text = "\nDisturbances with strengths:\n";
  for (const StrengthLadder& ladder : strength_ladders()) {
    std::vector<std::string> strengths;
    for (const double strength : ladder.strengths) strengths.push_back(fmt::format("{:g}", strength));
    text += fmt::format("  {:<8} {}: {} ({})\n", ladder.name, ladder.title, fmt::join(strengths, ", "), ladder.unit);
  }
  return text;
}

/// As a benchmark, and the maps too.
BenchmarkTools tools_of(const BenchmarkSetup& setup, const CompareFlags& flags) {
  BenchmarkTools tools = benchmark_tools(setup, flags.quiet);
  tools.score = [score = tools.score](const std::filesystem::path& folder, const BenchmarkJudgment& judgment,
                                      const std::filesystem::path& map_folder) {
    RunScores scores = score(folder, judgment, map_folder);
    if (judgment.measures_map && (scores.alignment == "se3" || scores.alignment == "sim3"))
      add_map_figures(folder, judgment.ground_truth, scores.figures);
    return scores;
  };
  return tools;
}

void write_reports(const Comparison& comparison, const std::filesystem::path& out) {
  const Report report = report_of(comparison);
  const bool is_complete = comparison.runs.size() == comparison.planned;
  if (is_complete) write_map_pages(report, out);
  write_whole_file(out / "report.html", report_as_html(report, out));
  write_whole_file(out / "report.md", report_as_markdown(report));
  write_whole_file(out / "report.tex", report_as_latex(report));
  write_whole_file(out / "report.csv", report_as_csv(comparison));
  for (const PaperTable& table : report.paper)
    fmt::print("\n{}\n{}{}{}", table.title, aligned_text(table.rows), table.note, table.note.empty() ? "" : "\n");
  fmt::print("\n{}", aligned_text(difference_rows(report.differences)));
  if (!report.by_auto.empty()) fmt::print("\n{}", aligned_text(auto_rows(report.by_auto)));
  if (!comparison.strengths.empty()) fmt::print("\n{}", aligned_text(strength_rows(comparison)));
  for (const UseCaseAdvice& advice : report.advice) fmt::print("\n{}. {}\n", advice.title, advice.text);
  fmt::print("\nreports: {0}/report.html, report.md, report.tex, report.csv\n", out.string());
}

CompareFlags with_paper_defaults(CompareFlags flags) {
  constexpr std::uint64_t maps = 5;
  if (flags.inputs.empty()) {
    flags.inputs = paper_inputs();
    if (flags.disturbances.empty()) flags.disturbances = paper_disturbances();
  }
  if (!flags.seeds_given) flags.seeds = maps;
  return flags;
}

/// Table I of the front-end paper; all else in the report is there without it.
void add_front_end(const CompareSession& session, Comparison& comparison) {
  try {
    comparison.front_end = front_end_figures(comparison.inputs, session.recordings());
  } catch (const Interrupted&) {
    fmt::print(stderr, "interrupted: the report lacks table I; the same command goes on\n");
  }
}

int compare_until_interrupted(const CompareFlags& given) {
  const CompareFlags flags = given.paper ? with_paper_defaults(given) : given;
  if (flags.inputs.empty() && !flags.paper)
    throw Error("needs an input", "rastro compare", "give a recording, a world, a list (.yaml), or --paper");
  const std::string data = data_folder(flags.data);
  std::vector<Import> imports;
  for (const std::string& text : flags.imports) imports.push_back(parse_import(text));
  const std::vector<StrengthLadder> ladders = ladders_named(flags.disturbances);
  const CompareTask task = task_of(flags, data);
  const BenchmarkSetup setup = benchmark_setup(session_of(flags, task), true);
  CompareSession session(task, setup, tools_of(setup, flags), data);
  if (flags.dry_run) {
    fmt::print("{}", session.plan_text());
    return done;
  }
  const auto scored_imports = score_imports(imports, session.inputs(), session.recordings(), session.columns());
  std::vector<StrengthCurve> strengths;
  bool complete = session.run();
  if (complete && !ladders.empty()) complete = climb_ladders(ladders, session, strengths);
  Comparison comparison = session.comparison();
  comparison.strengths = strengths;
  comparison.paper = flags.paper;
  if (flags.paper && complete) add_front_end(session, comparison);
  add_imports(scored_imports, comparison);
  comparison.command = command_line();
  if (!complete) fmt::print(stderr, "{}; the same command goes on\n", interruption_text(comparison));
  fmt::print("{}", comparison_as_text(comparison));
  write_reports(comparison, flags.session.out);
  const auto& runs = comparison.runs;
  const bool none =
      !runs.empty() && std::all_of(runs.begin(), runs.end(), [](const auto& run) { return run.failed(); });
  return none ? limit_missed : done;
}

int compare(const CompareFlags& flags) {
  try {
    return compare_until_interrupted(flags);
  } catch (const Interrupted&) {
    fmt::print(stderr, "interrupted before the first run; the same command goes on\n");
    return done;
  }
}

void add_run_flags(CLI::App& command, CompareFlags& flags) {
  const char* group = "Runs";
  command.add_option("--seeds", flags.seeds, "Seeds 1 to N of each world (default: 1)")->type_name("N")->group(group);
  command
      .add_option("--repeat", flags.repeats,
                  "Repeat each run with seeds 1 to N of its random numbers, and the first once more for its bytes "
                  "(default: 1)")
      ->type_name("N")
      ->group(group);
  command.add_option("--jobs", flags.session.jobs, "Runs at the same time; times are best measured with 1")
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  command.add_option("--threads", flags.session.threads, "Threads of each run (default: all cores divided by --jobs)")
      ->type_name("N")
      ->group(group);
  command
      .add_option("--timeout", flags.timeout_s,
                  "A run that takes longer is stopped and fails; with more time it is run again (default: that of the "
                  "list, else 3600)")
      ->type_name("S")
      ->group(group);
  command.add_flag("--force", flags.session.force, "Run again what has a result")->group(group);
  command
      .add_flag("--dry-run", flags.dry_run,
                "Print the runs and their commands only; worlds are generated, to see what they hold")
      ->group(group);
}

void add_input_flags(CLI::App& command, CompareFlags& flags) {
  const char* group = "Input, of all recordings";
  command.add_option("--data", flags.data, "Folder of recordings (default: $RASTRO_DATA, else ../shared/data)")
      ->type_name("DIR")
      ->group(group);
  command.add_option("--frames", flags.frames, "Frames A to B-1 only, also of worlds")->type_name("A:B")->group(group);
  command.add_option("--every", flags.every, "Every N-th frame only")->type_name("N")->group(group);
  command.add_option("--rate", flags.rate, "Frame rate in Hz for data without timestamps")
      ->type_name("HZ")
      ->group(group);
  command.add_option("--calibration", flags.calibration, "Calibration file")->type_name("FILE")->group(group);
  command.add_option("--intrinsics", flags.intrinsics, "Pinhole intrinsics in pixels, without distortion")
      ->type_name("fx,fy,cx,cy")
      ->group(group);
  command.add_option("--fov", flags.fov, "Horizontal field of view in degrees")->type_name("DEG")->group(group);
}

}  // namespace

void add_compare_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("compare", "Runs all methods on the same inputs and compares their figures");
  const auto flags = std::make_shared<CompareFlags>();
  command
      ->add_option(
          "INPUT", flags->inputs,
          "Recordings and worlds, each alone or quoted with its flags; or one list of 'rastro benchmark' (.yaml)")
      ->type_name("");
  command->add_flag(
      "--paper", flags->paper,
      "Beside the papers' tables and figures: rooms (lengths, behavior) and a drive (front-end, odometry) or INPUT, 5 "
      "seeds each (--seeds)");
  command->add_option("--methods", flags->methods, "Methods: all, or names")
      ->type_name("all|M,M")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--out", flags->session.out, "Folder of the results; kept from call to call")
      ->type_name("DIR")
      ->required();
  add_run_flags(*command, *flags);
  add_input_flags(*command, *flags);
  command
      ->add_option("--import", flags->imports,
                   "Trajectory of another program as a further column, and its cloud; may be repeated")
      ->type_name("NAME[@INPUT]=FILE[,cloud.ply][,sim3][,body]")
      ->allow_extra_args(false);
  command
      ->add_option("--disturb", flags->disturbances,
                   "Find the strength at which each method fails: default (all), or names, see below")
      ->type_name("default|NAME,NAME")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_flag("--quiet", flags->quiet, "No line after each run");
  command->footer(compare_footer + disturbances_text());
  command->callback([command, flags, &context] {
    flags->seeds_given = command->count("--seeds") > 0;
    context.exit_code = compare(*flags);
  });
}

}  // namespace rastro::cli
