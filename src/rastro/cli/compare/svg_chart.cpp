// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace rastro::cli {
namespace {

constexpr double width = 640.0, height = 340.0;
constexpr double left = 62.0, right = 12.0, top = 12.0, bottom = 44.0;
constexpr std::size_t most_points = 300;
constexpr std::size_t color_count = 12;

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  bool is_empty() const { return !(low <= high); }
  double size() const { return high - low; }
  void add(double value) { low = std::min(low, value), high = std::max(high, value); }
  void widen_to(double wanted) {
    const double more = 0.5 * std::max(0.0, wanted - size());
    low -= more, high += more;
  }
};

/// Where values are on the paper.
struct Axes {
  Range x, y;
  bool log_y = false;

  double of_y(double value) const { return log_y ? std::log10(value) : value; }
  double at_x(double value) const { return left + (value - x.low) / x.size() * (width - left - right); }
  double at_y(double value) const {
    return height - bottom - (of_y(value) - y.low) / y.size() * (height - top - bottom);
  }
};

bool is_drawn(const Chart& chart, double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && (!chart.log_y || y > 0.0);
}

Axes axes_of(const Chart& chart) {
  Axes axes;
  axes.log_y = chart.log_y;
  for (const ChartLine& line : chart.lines) {
    for (std::size_t k = 0; k < line.x.size(); ++k) {
      if (!is_drawn(chart, line.x[k], line.y[k])) continue;
      axes.x.add(line.x[k]);
      axes.y.add(axes.of_y(line.y[k]));
    }
  }
  if (axes.x.is_empty()) return axes;
  if (!chart.equal_axes && !chart.log_y) axes.y.add(0.0);
  if (axes.x.size() < 1e-9) axes.x.widen_to(std::max(1e-6, 0.4 * std::abs(axes.x.low)));
  axes.x.widen_to(std::max(1e-9, 1.02 * axes.x.size()));
  axes.y.widen_to(std::max(1e-9, 1.05 * axes.y.size()));
  if (!chart.equal_axes) return axes;
  const double unit = std::max(axes.x.size() / (width - left - right), axes.y.size() / (height - top - bottom));
  axes.x.widen_to(unit * (width - left - right));
  axes.y.widen_to(unit * (height - top - bottom));
  return axes;
}

std::vector<double> ticks_of_y(const Axes& axes) {
  if (!axes.log_y) return round_ticks(axes.y.low, axes.y.high);
  std::vector<double> ticks;
  for (int power = static_cast<int>(std::floor(axes.y.low)); power <= static_cast<int>(std::ceil(axes.y.high)); ++power)
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, power);
      if (std::log10(value) >= axes.y.low && std::log10(value) <= axes.y.high) ticks.push_back(value);
    }
  if (ticks.size() < 3) return round_ticks(std::pow(10.0, axes.y.low), std::pow(10.0, axes.y.high));
  return ticks;
}

std::string grid_of(const Axes& axes) {
  std::string svg;
  for (const double tick : round_ticks(axes.x.low, axes.x.high))
    svg += fmt::format(
        R"(<line class="grid" x1="{0:.1f}" x2="{0:.1f}" y1="{1}" y2="{2}"/><text class="axis" x="{0:.1f}" y="{3}" text-anchor="middle">{4:g}</text>)",
        axes.at_x(tick), top, height - bottom, height - bottom + 16.0, tick);
  for (const double tick : ticks_of_y(axes))
    svg += fmt::format(
        R"(<line class="grid" x1="{1}" x2="{2}" y1="{0:.1f}" y2="{0:.1f}"/><text class="axis" x="{3}" y="{4:.1f}" text-anchor="end">{5:g}</text>)",
        axes.at_y(tick), left, width - right, left - 6.0, axes.at_y(tick) + 4.0, tick);
  return svg;
}

std::string class_of(const ChartLine& line) {
  return line.is_reference ? "reference" : fmt::format("c{}", line.color % color_count);
}

std::string line_of(const Chart& chart, const ChartLine& line, const Axes& axes) {
  const std::size_t step = 1 + line.x.size() / most_points;
  std::string points, dots;
  for (std::size_t k = 0; k < line.x.size(); ++k) {
    const bool is_last = k + 1 == line.x.size();
    if ((k % step != 0 && !is_last) || !is_drawn(chart, line.x[k], line.y[k])) continue;
    points += fmt::format("{:.1f},{:.1f} ", axes.at_x(line.x[k]), axes.at_y(line.y[k]));
    if (line.has_points)
      dots += fmt::format(R"(<circle class="dot {}" cx="{:.1f}" cy="{:.1f}" r="3"/>)", class_of(line),
                          axes.at_x(line.x[k]), axes.at_y(line.y[k]));
  }
  return fmt::format(R"(<polyline class="line {}" points="{}"><title>{}</title></polyline>{})", class_of(line), points,
                     escaped(line.name), dots);
}

std::string legend_of(const Chart& chart) {
  std::string html = "<figcaption>";
  for (const ChartLine& line : chart.lines)
    html += fmt::format(R"(<span class="key"><i class="{}"></i>{}</span> )", class_of(line), escaped(line.name));
  return html + "</figcaption>";
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char letter : text) {
    if (letter == '&')
      safe += "&amp;";
    else if (letter == '<')
      safe += "&lt;";
    else if (letter == '>')
      safe += "&gt;";
    else if (letter == '"')
      safe += "&quot;";
    else
      safe += letter;
  }
  return safe;
}

std::vector<double> round_ticks(double low, double high) {
  if (!(high > low) || !std::isfinite(high - low)) return {low};
  const double rough = (high - low) / 5.0, power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double digit : {5.0, 2.0, 1.0})
    if (digit * power >= rough) step = digit * power;
  std::vector<double> ticks;
  for (double k = std::ceil(low / step); k * step <= high; k += 1.0) ticks.push_back(k * step + 0.0);  // no -0
  return ticks;
}

std::string svg_of(const Chart& chart) {
  const Axes axes = axes_of(chart);
  if (axes.x.is_empty()) return "";
  std::string html = fmt::format("<figure><h4>{}</h4>", escaped(chart.title));
  html += fmt::format(R"(<svg viewBox="0 0 {} {}" role="img" aria-label="{}">)", width, height, escaped(chart.title));
  html += grid_of(axes);
  html += fmt::format(R"(<text class="axis" x="{:.0f}" y="{:.0f}" text-anchor="middle">{}</text>)",
                      0.5 * (left + width), height - 6.0, escaped(chart.x_label));
  html += fmt::format(
      R"svg(<text class="axis" transform="translate(13,{:.0f}) rotate(-90)" text-anchor="middle">{}</text>)svg",
      0.5 * (height - bottom), escaped(chart.y_label));
  for (const ChartLine& line : chart.lines) html += line_of(chart, line, axes);
  return html + "</svg>" + legend_of(chart) + "</figure>\n";
}

}  // namespace rastro::cli
