// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/grid/log_odds_grid.h"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace rastro {

void LogOddsGrid::insert(const Eigen::Vector2d& sensor, std::span<const Eigen::Vector2d> returns) {
  const ScanCells scan(cell_m_, sensor, returns);
  grow_to_hold(scan);
  ++scans_;
  const std::uint32_t by_return = 2 * scans_ + 1;
  for (const Eigen::Vector2i& end : scan.returns) {
    const std::size_t cell = index_of(end);
    if (touched_[cell] == by_return) continue;
    touched_[cell] = by_return;
    set(cell, steps_.after_return(log_odds_[cell]));
  }
  for (const Eigen::Vector2i& end : scan.returns) draw_beam(scan.sensor, end);
}

void LogOddsGrid::draw_beam(const Eigen::Vector2i& from, const Eigen::Vector2i& to) {
  const std::uint32_t by_beam = 2 * scans_;
  const auto row = static_cast<std::ptrdiff_t>(box_.size.x());
  const auto first = static_cast<std::ptrdiff_t>(index_of(from));
  walk_beam<std::ptrdiff_t>(to - from, first, 1, row, [&](std::ptrdiff_t position) {
    const auto cell = static_cast<std::size_t>(position);
    if (touched_[cell] >= by_beam) return;
    touched_[cell] = by_beam;
    set(cell, steps_.after_passing_beam(log_odds_[cell]));
  });
}

void LogOddsGrid::grow_to_hold(const ScanCells& scan) {
  if (box_.holds(scan)) return;
  const CellBox former = std::exchange(box_, box_.grown_to_hold(scan));
  // One after the other, so that only one of them is there twice.
  const auto grow = [&](auto& cells, auto fill) {
    std::decay_t<decltype(cells)> grown(
        static_cast<std::size_t>(box_.size.x()) * static_cast<std::size_t>(box_.size.y()), fill);
    for (int y = 0; y < former.size.y(); ++y) {
      const auto source = static_cast<std::ptrdiff_t>(y) * former.size.x();
      const auto target = static_cast<std::ptrdiff_t>(index_of(former.first + Eigen::Vector2i(0, y)));
      std::copy_n(cells.begin() + source, former.size.x(), grown.begin() + target);
    }
    cells = std::move(grown);
  };
  grow(log_odds_, std::int16_t{0});
  grow(probability_, LogOddsSteps::nothing_known);
  grow(touched_, std::uint32_t{0});
}

ProbabilityView LogOddsGrid::view() const {
  return {probability_.data(), box_.size.x(), box_.size.y(), cell_m_, cell_m_ * box_.first.cast<double>()};
}

void LogOddsGrid::freeze() {
  // "= {}" would empty them and keep their memory.
  log_odds_ = std::vector<std::int16_t>();
  touched_ = std::vector<std::uint32_t>();
}

std::size_t LogOddsGrid::bytes() const {
  return log_odds_.capacity() * sizeof(std::int16_t) + probability_.capacity() * sizeof(std::uint8_t) +
         touched_.capacity() * sizeof(std::uint32_t);
}

}  // namespace rastro
