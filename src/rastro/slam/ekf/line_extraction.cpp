// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/line_extraction.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

namespace rastro {
namespace {

ScanLine fit(std::span<const ScanPoint> points, double beam_noise_m) {
  const auto count = static_cast<double>(points.size());
  ScanLine line{0, 0, Eigen::Vector2d::Zero(), Eigen::Vector2d::UnitX(), Eigen::Matrix2d::Zero()};
  for (const ScanPoint& point : points) line.center += point.position / count;
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const ScanPoint& point : points) {
    const Eigen::Vector2d offset = point.position - line.center;
    spread += offset * offset.transpose();
  }
  line.direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvectors().col(1);
  if (line.direction.dot(points.back().position - points.front().position) < 0.0) line.direction *= -1.0;

  double offset = 0.0, mixed = 0.0, rotation = 0.0, square = 0.0;
  for (const ScanPoint& point : points) {
    // The noise is along the beam; only its component across the line moves the line.
    const double across = line.normal().dot(point.position) / point.range * beam_noise_m;
    const double along = line.direction.dot(point.position - line.center);
    offset += across * across;
    mixed += along * across * across;
    rotation += along * along * across * across;
    square += along * along;
  }
  line.covariance << offset / (count * count), mixed / (count * square), mixed / (count * square),
      rotation / (square * square);
  return line;
}

/// A range of points of a run, including the last one.
struct PointRange {
  std::size_t first = 0, last = 0;
  std::size_t count() const { return last - first + 1; }
};

class LineFinder {
 public:
  LineFinder(std::span<const ScanPoint> run, std::size_t reach, const EkfOptions& options, Random& random)
      : run_(run), reach_(reach), options_(options), random_(random) {}

  std::vector<ScanLine> find_all() {
    std::vector<ScanLine> lines;
    std::vector<PointRange> open;
    if (!run_.empty()) open.push_back({0, run_.size() - 1});
    while (!open.empty()) {
      const PointRange range = open.back();
      open.pop_back();
      if (range.count() < static_cast<std::size_t>(options_.min_line_beams)) continue;
      const auto line = find(range);
      if (!line) continue;
      lines.push_back(*line);
      if (line->first > range.first) open.push_back({range.first, line->first - 1});
      if (line->last < range.last) open.push_back({line->last + 1, range.last});
    }
    std::sort(lines.begin(), lines.end(), [](const ScanLine& a, const ScanLine& b) { return a.first < b.first; });
    return lines;
  }

 private:
  /// The longest line in the range, if there is one.
  std::optional<ScanLine> find(const PointRange& range) {
    PointRange best{0, 0};
    for (int i = 0; i < options_.ransac_iterations; ++i) {
      const auto grown = grown_sample(range);
      if (grown && grown->count() > best.count()) best = *grown;
    }
    return refined(best, range);
  }

  std::optional<PointRange> grown_sample(const PointRange& range) {
    const std::size_t a = range.first + random_.below(static_cast<std::uint32_t>(range.count() - 1));
    const std::size_t reach = std::min(reach_, range.last - a);
    const std::size_t b = a + 1 + random_.below(static_cast<std::uint32_t>(reach));
    const Eigen::Vector2d offset = run_[b].position - run_[a].position;
    if (offset.squaredNorm() < 1e-12) return std::nullopt;
    ScanLine line;
    line.center = run_[a].position;
    line.direction = offset.normalized();
    for (std::size_t between = a + 1; between < b; ++between) {
      if (!is_on(line, between)) return std::nullopt;
    }
    return grown(line, {a, b}, range);
  }

  std::optional<ScanLine> refined(PointRange found, const PointRange& range) const {
    constexpr int rounds = 4;
    for (int round = 0; round < rounds; ++round) {
      if (found.count() < static_cast<std::size_t>(options_.min_line_beams)) return std::nullopt;
      const ScanLine line = fit_line(run_, found.first, found.last, options_);
      const std::size_t middle = found.first + found.count() / 2;
      const PointRange next = grown(line, {middle, middle}, range);
      if (next.first == found.first && next.last == found.last) break;
      found = next;
    }
    const bool long_enough = (run_[found.last].position - run_[found.first].position).norm() >= options_.min_line_m &&
                             found.count() >= static_cast<std::size_t>(options_.min_line_beams);
    if (!long_enough) return std::nullopt;
    return fit_line(run_, found.first, found.last, options_);
  }

  bool is_on(const ScanLine& line, std::size_t point) const {
    return std::abs(line.distance(run_[point].position)) <= options_.line_tolerance_m;
  }

  PointRange grown(const ScanLine& line, PointRange part, const PointRange& whole) const {
    for (;;) {
      if (part.first > whole.first && is_on(line, part.first - 1)) {
        --part.first;
      } else if (part.first > whole.first + 2 && is_on(line, part.first - 2) && is_on(line, part.first - 3)) {
        part.first -= 3;
      } else {
        break;
      }
    }
    for (;;) {
      if (part.last < whole.last && is_on(line, part.last + 1)) {
        ++part.last;
      } else if (part.last + 2 < whole.last && is_on(line, part.last + 2) && is_on(line, part.last + 3)) {
        part.last += 3;
      } else {
        break;
      }
    }
    return part;
  }

  std::span<const ScanPoint> run_;
  std::size_t reach_;
  const EkfOptions& options_;
  Random& random_;
};

}  // namespace

std::vector<std::vector<ScanPoint>> runs_of(const LaserScan& scan, const EkfOptions& options) {
  std::vector<std::vector<ScanPoint>> runs;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.is_return(beam)) continue;
    const double range = static_cast<double>(scan.ranges[beam]), angle = scan.angle_of(beam);
    if (range > options.max_beam_m || !(range > 0.0)) continue;
    const Eigen::Vector2d position(range * std::cos(angle), range * std::sin(angle));
    if (!position.allFinite()) continue;
    const double gap = std::max(options.beam_gap_m, options.beam_gap_share * range);
    if (runs.empty() || (runs.back().back().position - position).norm() > gap) runs.emplace_back();
    runs.back().push_back({position, range, beam});
  }
  return runs;
}

ScanLine fit_line(std::span<const ScanPoint> run, std::size_t first, std::size_t last, const EkfOptions& options) {
  const auto points = run.subspan(first, last - first + 1);
  const ScanLine all = fit(points, options.beam_noise_m);
  std::vector<ScanPoint> near;
  std::copy_if(points.begin(), points.end(), std::back_inserter(near), [&](const ScanPoint& point) {
    return std::abs(all.distance(point.position)) <= options.line_tolerance_m;
  });
  ScanLine line = near.size() > 1 && near.size() < points.size() ? fit(near, options.beam_noise_m) : all;
  line.first = first;
  line.last = last;
  return line;
}

std::vector<ScanLine> extract_lines(std::span<const ScanPoint> run, std::size_t reach_beams, const EkfOptions& options,
                                    Random& random) {
  return LineFinder(run, std::max<std::size_t>(1, reach_beams), options, random).find_all();
}

}  // namespace rastro
