// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/report_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/cli/compare/map_pages.h"
#include "rastro/cli/compare/strengths.h"
#include "rastro/cli/compare/svg_chart.h"
#include "rastro/export/thumbnail.h"
#include "rastro/synthetic/disturbance/disturbance.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr int map_px = 420, failure_px = 320;
constexpr std::size_t most_failures = 24;

std::size_t color_of(const Comparison& comparison, const std::string& column) {
  const auto& columns = comparison.table.columns();
  return static_cast<std::size_t>(std::find(columns.begin(), columns.end(), column) - columns.begin());
}

/// The run that the chosen trace is of; nullptr for an import.
const FinishedRun* run_of(const Comparison& comparison, const ColumnTrace& trace) {
  for (const FinishedRun& run : comparison.runs)
    if (run.is_plain() && run.what.input == trace.input && run.what.column == trace.column && run.seed == trace.seed &&
        run.what.repeat == trace.repeat)
      return &run;
  return nullptr;
}

/// The two axes of the world along which the reference is widest: of a walk those of the ground.
std::array<int, 2> ground_axes(const Trajectory& poses) {
  Eigen::Vector3d low = poses.front().world_from_body.translation(), high = low;
  for (const StampedPose& pose : poses) {
    low = low.cwiseMin(pose.world_from_body.translation());
    high = high.cwiseMax(pose.world_from_body.translation());
  }
  int narrowest = 0;
  (high - low).minCoeff(&narrowest);
  return narrowest == 0 ? std::array{1, 2} : narrowest == 1 ? std::array{0, 2} : std::array{0, 1};
}

ChartLine path_line(const std::string& name, const Trajectory& poses, const std::array<int, 2>& axes) {
  ChartLine line;
  line.name = name;
  for (const StampedPose& pose : poses) {
    line.x.push_back(pose.world_from_body.translation()[axes[0]]);
    line.y.push_back(pose.world_from_body.translation()[axes[1]]);
  }
  return line;
}

/// The part that the run was matched with.
Trajectory matched_part(const RunTrace& trace) {
  const Trajectory& poses = trace.reference->input.poses;
  const auto begin = poses.begin() + static_cast<std::ptrdiff_t>(trace.scores.pairs.front().reference);
  return {begin, poses.begin() + static_cast<std::ptrdiff_t>(trace.scores.pairs.back().reference) + 1};
}

std::string figure_with(const std::string& image, const std::string& caption) {
  return fmt::format(R"(<figure class="picture"><img src="{}" alt=""><figcaption>{}</figcaption></figure>)", image,
                     caption);
}

std::string link_to(const fs::path& target, const fs::path& folder, const std::string& text) {
  return fmt::format("<a href=\"{}\">{}</a>", escaped(fs::proximate(target, folder).generic_string()), text);
}

/// The frame as the run saw it; empty where it cannot be read again.
std::string picture_of(const Comparison& comparison, const FinishedRun& run, std::int64_t frame) {
  try {
    const CompareInput& input = comparison.inputs[run.what.input];
    OpenOptions options = open_options_of(run.recording, input.is_world() ? std::vector<std::string>() : input.flags);
    options.first_frame = frame, options.end_frame = frame + 1;
    options.every = 1, options.read_ahead = 0, options.want_color = true;
    auto source = rastro::open(run.recording, options);
    if (!source->info().has_image) return "";
    if (!run.what.disturbance.empty()) source = disturbed(std::move(source), run.what.disturbance);
    const auto read = source->next();
    return read ? thumbnail_of(*read, failure_px) : "";
  } catch (const Error&) {
    return "";
  }
}

/// Of "frame 12: few_points".
std::optional<std::int64_t> frame_number_of(const std::string& loss) {
  if (!loss.starts_with("frame ")) return std::nullopt;
  return parse_int64(loss.substr(6, loss.find(':') - 6));
}

Chart strength_chart(const Comparison& comparison, const StrengthLadder& ladder, std::size_t input, bool of_error) {
  Chart chart;
  chart.title = fmt::format("{}: {}, {}", comparison.inputs[input].name, ladder.title,
                            of_error ? "error by that without" : "completion by that without");
  chart.x_label = ladder.unit;
  chart.y_label = of_error ? "ratio of ATE" : "ratio of completion";
  chart.log_y = of_error;
  for (const StrengthCurve& curve : comparison.strengths) {
    if (curve.input != input || curve.disturbance != ladder.name) continue;
    ChartLine line{curve.column, {}, {}, color_of(comparison, curve.column), false, true};
    for (const StrengthStep& step : curve.steps) {
      const auto& value = of_error ? step.error_ratio : step.completion_ratio;
      if (!value) continue;
      line.x.push_back(step.strength);
      line.y.push_back(*value);
    }
    if (!line.x.empty()) chart.lines.push_back(std::move(line));
  }
  return chart;
}

}  // namespace

std::string charts_of(const Report& report, std::size_t input) {
  Chart errors{"Error over time", "seconds", "meters", {}, false, true};
  Chart paths{"Trajectories from above, aligned", "meters", "meters", {}, true, false};
  std::array<int, 2> axes{0, 1};
  for (const ColumnTrace* each : median_traces(report.traces, report.comparison.table.columns(), input)) {
    const RunTrace& trace = each->trace;
    const std::size_t color = color_of(report.comparison, each->column);
    const Trajectory reference = matched_part(trace);
    if (paths.lines.empty()) {
      axes = ground_axes(reference);
      paths.lines.push_back(path_line("ground truth", reference, axes));
      paths.lines.back().is_reference = true;
    }
    paths.lines.push_back(path_line(each->column, trace.scores.aligned, axes));
    paths.lines.back().color = color;
    errors.lines.push_back({each->column, trace.times_s(), trace.errors_m(), color, false, false});
  }
  return "<div class=\"charts\">" + svg_of(errors) + svg_of(paths) + "</div>\n";
}

std::string strength_charts_of(const Comparison& comparison) {
  std::string html = "<div class=\"charts\">";
  for (std::size_t input = 0; input < comparison.inputs.size(); ++input)
    for (const StrengthLadder& ladder : strength_ladders())
      for (const bool of_error : {true, false}) html += svg_of(strength_chart(comparison, ladder, input, of_error));
  return html + "</div>\n";
}

std::vector<PicturedRun> pictured_runs(const Report& report, std::size_t input) {
  std::vector<PicturedRun> pictured;
  for (const ColumnTrace* each : median_traces(report.traces, report.comparison.table.columns(), input))
    if (const FinishedRun* run = run_of(report.comparison, *each)) pictured.push_back({each->column, run});
  return pictured;
}

std::string maps_of(const Report& report, std::size_t input, const fs::path& folder) {
  std::string html;
  for (const auto& [column, run] : pictured_runs(report, input)) {
    const std::string image = thumbnail_of((run->folder / "map.png").string(), map_px);
    if (image.empty()) continue;
    std::string caption = escaped(column) + ": ";
    const fs::path page = map_page_of(*run, folder);
    if (std::error_code ignored; fs::exists(page, ignored)) caption += link_to(page, folder, "map in 3D") + ", ";
    caption += link_to(run->folder, folder, "run folder");
    html += figure_with(
        image, caption + fmt::format(", <code>rastro view {}</code>", escaped(as_shell_word(run->folder.string()))));
  }
  return html.empty() ? "" : "<div class=\"pictures\">" + html + "</div>\n";
}

std::string failures_of(const Comparison& comparison) {
  std::string pictures, lines;
  std::size_t count = 0;
  for (const FinishedRun& run : comparison.runs) {
    if (run.what.again) continue;
    const std::string& loss = run.result.scores.first_loss;
    if (run.failed())
      lines += fmt::format("<li>{}: {}<br><code>{}</code></li>\n", escaped(run.result.entry),
                           escaped(run.result.failure), escaped(run.run_command));
    const auto frame = frame_number_of(loss);
    if (!frame || count >= most_failures || run.what.repeat > 1) continue;
    const std::string image = picture_of(comparison, run, *frame);
    if (image.empty()) continue;
    ++count;
    pictures += figure_with(image, fmt::format("{}: lost in {}", escaped(run.result.entry), escaped(loss)));
  }
  if (!lines.empty()) lines = "<ul>" + lines + "</ul>\n";
  return pictures.empty() ? lines : lines + "<div class=\"pictures\">" + pictures + "</div>\n";
}

}  // namespace rastro::cli
