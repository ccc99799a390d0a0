// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/grid/log_odds_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <type_traits>
#include <utility>

namespace rastro {
namespace {

/// Log-odds are stored in steps of 1/256.
constexpr double steps = 256.0;
constexpr int farthest_cell = 32768;
/// Grown by more than required; otherwise a slow drive would grow the grid with every scan.
constexpr int spare_cells = 64;
constexpr std::uint8_t nothing_known = 128;

int log_odds_step(double probability) {
  return static_cast<int>(std::lround(steps * std::log(probability / (1.0 - probability))));
}

}  // namespace

LogOddsGrid::LogOddsGrid(double cell_m, const LogOddsModel& model)
    : cell_m_(cell_m),
      occupied_step_(log_odds_step(model.occupied_probability)),
      free_step_(log_odds_step(model.free_probability)),
      largest_(static_cast<int>(std::lround(steps * model.largest_log_odds))) {
  for (int value = -largest_; value <= largest_; ++value) {
    const double probability = 1.0 / (1.0 + std::exp(-value / steps));
    probability_of_.push_back(static_cast<std::uint8_t>(std::lround(255.0 * probability)));
  }
}

Eigen::Vector2i LogOddsGrid::cell_of(const Eigen::Vector2d& point) const {
  return {static_cast<int>(std::floor(point.x() / cell_m_)), static_cast<int>(std::floor(point.y() / cell_m_))};
}

void LogOddsGrid::insert(const Eigen::Vector2d& sensor, std::span<const Eigen::Vector2d> returns) {
  const Eigen::Vector2i from = cell_of(sensor);
  std::vector<Eigen::Vector2i> ends;
  Eigen::Vector2i least = from, most = from;
  for (const Eigen::Vector2d& point : returns) {
    const Eigen::Vector2i end = cell_of(point);
    if ((end - from).cwiseAbs().maxCoeff() >= farthest_cell) continue;
    least = least.cwiseMin(end);
    most = most.cwiseMax(end);
    ends.push_back(end);
  }
  grow_to_hold(least, most);
  ++scans_;
  const std::uint32_t by_return = 2 * scans_ + 1;
  for (const Eigen::Vector2i& end : ends) {
    const std::size_t cell = index_of(end);
    if (touched_[cell] == by_return) continue;
    touched_[cell] = by_return;
    add(cell, occupied_step_);
  }
  for (const Eigen::Vector2i& end : ends) draw_beam(from, end);
}

/// The cells in between, without the last, by Bresenham's line.
void LogOddsGrid::draw_beam(const Eigen::Vector2i& from, const Eigen::Vector2i& to) {
  const int dx = std::abs(to.x() - from.x()), dy = std::abs(to.y() - from.y());
  const std::ptrdiff_t row = size_.x();
  std::ptrdiff_t along = to.x() >= from.x() ? 1 : -1, across = to.y() >= from.y() ? row : -row;
  int length = dx, width = dy;
  if (dy > dx) {
    std::swap(along, across);
    std::swap(length, width);
  }
  auto cell = static_cast<std::ptrdiff_t>(index_of(from));
  int error = length / 2;
  for (int i = 0; i < length; ++i) {
    const auto here = static_cast<std::size_t>(cell);
    if (touched_[here] < 2 * scans_) {
      touched_[here] = 2 * scans_;
      add(here, free_step_);
    }
    error -= width;
    if (error < 0) {
      error += length;
      cell += across;
    }
    cell += along;
  }
}

void LogOddsGrid::add(std::size_t cell, int log_odds) {
  const int sum = std::clamp(log_odds_[cell] + log_odds, -largest_, largest_);
  log_odds_[cell] = static_cast<std::int16_t>(sum);
  probability_[cell] = probability_of_[static_cast<std::size_t>(sum + largest_)];
}

void LogOddsGrid::grow_to_hold(const Eigen::Vector2i& least, const Eigen::Vector2i& most) {
  if (size_.x() > 0 && (least.array() >= first_.array()).all() && (most.array() < (first_ + size_).array()).all())
    return;
  Eigen::Vector2i first = least.array() - spare_cells, end = most.array() + spare_cells + 1;
  if (size_.x() > 0) {
    first = first.cwiseMin(first_);
    end = end.cwiseMax(first_ + size_);
  }
  const Eigen::Vector2i size = end - first;
  // One after the other, so that only one of them is there twice.
  const auto grow = [&](auto& cells, auto fill) {
    std::decay_t<decltype(cells)> grown(static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()), fill);
    for (int y = 0; y < size_.y(); ++y) {
      const auto source = static_cast<std::ptrdiff_t>(y) * size_.x();
      const std::ptrdiff_t target =
          static_cast<std::ptrdiff_t>(y + first_.y() - first.y()) * size.x() + (first_.x() - first.x());
      std::copy_n(cells.begin() + source, size_.x(), grown.begin() + target);
    }
    cells = std::move(grown);
  };
  grow(log_odds_, std::int16_t{0});
  grow(probability_, nothing_known);
  grow(touched_, std::uint32_t{0});
  first_ = first;
  size_ = size;
}

ProbabilityView LogOddsGrid::view() const {
  return {probability_.data(), size_.x(), size_.y(), cell_m_, cell_m_ * first_.cast<double>()};
}

void LogOddsGrid::freeze() {
  log_odds_ = {};
  touched_ = {};
  probability_.shrink_to_fit();
}

OccupancyGrid to_occupancy(const ProbabilityView& view) {
  OccupancyGrid grid;
  grid.cell_m = view.cell_m;
  grid.origin = view.origin;
  grid.width = view.width;
  grid.height = view.height;
  const auto cells = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  grid.percent.resize(cells, OccupancyGrid::unknown);
  for (std::size_t i = 0; i < cells; ++i) {
    if (view.cells[i] == nothing_known) continue;
    grid.percent[i] = static_cast<std::int8_t>((100 * view.cells[i] + 127) / 255);
  }
  return grid;
}

}  // namespace rastro
