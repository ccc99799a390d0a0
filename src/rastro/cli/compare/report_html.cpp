// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/report_html.h"

#include <fmt/format.h>

#include "rastro/cli/compare/report_pictures.h"
#include "rastro/cli/compare/svg_chart.h"

namespace rastro::cli {
namespace {

constexpr const char* style = R"(<style>
:root{--paper:#fff;--ink:#1b1f24;--soft:#59636e;--rule:#d8dee4;--c0:#1f77b4;--c1:#d95f02;--c2:#2a8f3c;--c3:#c2255c;--c4:#7048e8;
--c5:#8c564b;--c6:#e64980;--c7:#5c677d;--c8:#9c8500;--c9:#0b8fa3;--c10:#a61e4d;--c11:#3b5bdb}
@media (prefers-color-scheme:dark){:root{--paper:#14171b;--ink:#e6e9ed;--soft:#9aa4af;--rule:#343b44;--c0:#6cb2eb;--c1:#ff9f43;
--c2:#69db7c;--c3:#ff6b8b;--c4:#b197fc;--c5:#d7a48f;--c6:#faa2c1;--c7:#adb5bd;--c8:#e6cf3c;--c9:#4dd4e8;--c10:#e599b8;--c11:#91a7ff}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:1240px;padding:16px;background:var(--paper);color:var(--ink);font:15px/1.5 system-ui,sans-serif}
h1{font-size:26px;margin:8px 0}h2{font-size:20px;margin:32px 0 8px;border-top:1px solid var(--rule);padding-top:16px}
h3{font-size:16px;margin:20px 0 6px}h4{font-size:14px;margin:0 0 4px}p{max-width:80ch}
code{font:12.5px ui-monospace,monospace;overflow-wrap:anywhere}
.scroll{overflow-x:auto;margin:8px 0}
table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums;white-space:nowrap}
th,td{padding:4px 9px;border-bottom:1px solid var(--rule);text-align:right}th{color:var(--soft);font-weight:600}
th:first-child,td:first-child{text-align:left;position:sticky;left:0;background:var(--paper)}
td.text{text-align:left}
.charts,.pictures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,400px),1fr));gap:16px;margin:12px 0}
.pictures{grid-template-columns:repeat(auto-fill,minmax(min(100%,240px),1fr))}
figure{margin:0;min-width:0}figure img{max-width:100%;max-height:320px;border:1px solid var(--rule)}
figcaption{font-size:12.5px;color:var(--soft);overflow-wrap:anywhere}
svg{width:100%;height:auto}.axis{fill:var(--soft);font-size:14px}.grid{stroke:var(--rule);stroke-width:1}
.line{fill:none;stroke-width:1.8}.reference{stroke:var(--ink);stroke-dasharray:5 4}
.key{white-space:nowrap;margin-right:10px}.key i{display:inline-block;width:14px;height:4px;margin-right:4px;vertical-align:middle}
.key i.reference{background:var(--ink)}
details{margin:8px 0}summary{cursor:pointer;color:var(--soft)}
</style>
)";

std::string counted(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

std::string color_classes() {
  std::string css = "<style>";
  for (int k = 0; k < 12; ++k)
    css +=
        fmt::format(".c{0}{{stroke:var(--c{0})}}.key i.c{0}{{background:var(--c{0})}}.dot.c{0}{{fill:var(--c{0})}}", k);
  return css + "</style>\n";
}

std::string advice_of(const Report& report) {
  std::string html = "<h2>Which method for what</h2>\n";
  for (const UseCaseAdvice& advice : report.advice)
    html += fmt::format("<p><b>{}.</b> {}</p>\n", escaped(advice.title), escaped(advice.text));
  html += "<h2>The best of each sensor</h2>\n" + html_table(summary_rows(report.comparison));
  if (report.by_auto.empty()) return html;
  return html +
         "<h2>What auto makes of it</h2>\n<p>Beside the best of the SLAM methods that were run by name and are "
         "aligned alike, of those that track about as many frames as the most complete accurate one.</p>\n" +
         html_table(auto_rows(report.by_auto));
}

std::string differences_of(const Report& report) {
  if (report.differences.empty()) return "";
  return "<h2>Differences</h2>\n<p>ATE over the frames that both track, each aligned over just these, paired by input, "
         "seed and "
         "repeat. Ratio: the median over the pairs; repeats of one input count as their median. p: Wilcoxon's "
         "signed-rank test of the logarithms, two-sided: exact up to 60 pairs with a difference (all signs of their "
         "ranks "
         "are counted, equal sizes share a rank), beyond that the normal approximation; Holm's correction over this "
         "table. With five pairs p cannot be below 0.063. No path: runs of the one and the other that failed or "
         "tracked nothing; such a run is worse than any with a path, and where neither has one the pair tells "
         "nothing. Runs with fewer than ten frames in common are left out; the verdict counts them. Where the one with "
         "the smaller error tracks fewer frames, by more than 5 points, the errors alone "
         "do not rank the two.</p>\n" +
         html_table(difference_rows(report.differences));
}

/// Every run with the commands that give its figures.
std::string commands_of(const Comparison& comparison, std::size_t input) {
  std::string html = "<details><summary>Commands of these figures</summary><ul>";
  for (const FinishedRun& run : comparison.runs) {
    if (run.what.input != input || !run.what.disturbance.empty()) continue;
    const std::string seed = run.seed == 0 ? "" : fmt::format(" seed {}", run.seed);
    html += fmt::format("<li>{}{}<br><code>{}</code>", escaped(run.result.entry), seed, escaped(run.run_command));
    if (!run.evaluate_command.empty()) html += fmt::format("<br><code>{}</code>", escaped(run.evaluate_command));
    for (const char* figure : {"surface_median_m", "length_max_m"})
      for (const Sample& sample : comparison.table.samples(comparison.inputs[input].name, run.what.column, figure))
        if (sample.seed == run.seed && sample.repeat == run.what.repeat && !run.what.again)
          html += fmt::format("<br><code>{}</code>", escaped(sample.command));
    html += "</li>\n";
  }
  for (const ImportedTrajectory& import : comparison.imported)
    if (import.input == input)
      html += fmt::format("<li>{}<br><code>{}</code></li>\n", escaped(import.column), escaped(import.command));
  return html + "</ul></details>\n";
}

std::string input_section(const Report& report, std::size_t input, const std::filesystem::path& folder) {
  const Comparison& comparison = report.comparison;
  const std::string& name = comparison.inputs[input].name;
  std::string html = fmt::format("<h2>{}</h2>\n", escaped(name));
  html += html_table(rows_on(comparison, input, true));
  html += fmt::format("<p>{}</p>\n", escaped(values_text(comparison)));
  html += charts_of(report, input) + maps_of(report, input, folder);
  const TextRows lengths = length_rows(comparison, name), stages = stage_rows(comparison, name);
  if (lengths.size() > 1) html += "<h3>Errors of the named lengths, mm</h3>\n" + html_table(lengths);
  if (stages.size() > 1) html += "<h3>Time by stage, ms per frame</h3>\n" + html_table(stages);
  return html + commands_of(comparison, input);
}

std::string papers_of(const Report& report) {
  std::string html;
  for (const PaperTable& table : report.paper) {
    html += fmt::format("<h2>{}</h2>\n{}", escaped(table.title), html_table(table.rows));
    if (!table.note.empty()) html += fmt::format("<p>{}</p>\n", escaped(table.note));
    if (!table.charts.empty()) html += "<div class=\"charts\">";
    for (const Chart& chart : table.charts) html += svg_of(chart);
    if (!table.charts.empty()) html += "</div>\n";
  }
  return html;
}

std::string strengths_of(const Comparison& comparison) {
  if (comparison.strengths.empty()) return "";
  std::string html =
      "<h2>Disturbances</h2>\n<p>Each grows step by step until a method tracks less than 90 % of the frames that it "
      "tracks without it (those of a covered part left out), or doubles its error.</p>\n" +
      html_table(strength_rows(comparison)) + strength_charts_of(comparison);
  html += "<details><summary>Commands of these figures</summary><ul>";
  for (const StrengthCurve& curve : comparison.strengths)
    for (const StrengthStep& step : curve.steps)
      html += fmt::format("<li><code>{}</code></li>\n", escaped(step.command));
  return html + "</ul></details>\n";
}

std::string explanations() {
  std::string html = "<h2>Figures</h2>\n<ul>";
  for (const FigureKind& figure : compare_figures())
    html += fmt::format("<li><b>{}</b>: {}</li>\n", escaped(figure.title), escaped(figure.explanation));
  return html +
         "</ul>\n<p>aligned: SE3 where the run claims meters, Sim3 where it does not, yaw where all poses lie in a "
         "plane. hector scan: laser scans cut out of the depth images as if the camera were level.</p>\n";
}

std::string not_run_of(const Comparison& comparison) {
  if (comparison.refused.empty()) return "";
  std::string html = "<details><summary>Not run, since the input lacks what they need</summary><ul>";
  for (const std::string& refused : comparison.refused) html += fmt::format("<li>{}</li>\n", escaped(refused));
  return html + "</ul></details>\n";
}

}  // namespace

std::string html_table(const TextRows& rows) {
  std::string html = "<div class=\"scroll\"><table>";
  for (std::size_t k = 0; k < rows.size(); ++k) {
    html += "<tr>";
    for (const std::string& cell : rows[k])
      html += k == 0 ? fmt::format("<th>{}</th>", escaped(cell)) : fmt::format("<td>{}</td>", escaped(cell));
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string report_as_html(const Report& report, const std::filesystem::path& folder) {
  const Comparison& comparison = report.comparison;
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>rastro compare</title>\n<meta "
      "name=\"viewport\" content=\"width=device-width,initial-scale=1\"><meta name=\"color-scheme\" content=\"light "
      "dark\">\n";
  html += style + color_classes() + "</head><body>\n";
  html += fmt::format("<h1>Comparison of {} on {}</h1>\n<p><code>{}</code></p>\n",
                      counted(comparison.table.columns().size(), "method"), counted(comparison.inputs.size(), "input"),
                      escaped(comparison.command));
  if (const std::string part = interruption_text(comparison); !part.empty())
    html += fmt::format("<p>This comparison was {}: medians and advice are of these alone.</p>\n", part);
  html += papers_of(report) + advice_of(report) + differences_of(report);
  for (std::size_t k = 0; k < comparison.inputs.size(); ++k) html += input_section(report, k, folder);
  html += strengths_of(comparison);
  const std::string failures = failures_of(comparison);
  if (!failures.empty()) html += "<h2>Failures and losses</h2>\n" + failures;
  return html + explanations() + not_run_of(comparison) + "</body></html>\n";
}

}  // namespace rastro::cli
