// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/expansion.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "rastro/base/error.h"

namespace rastro {
namespace {

/// Number of steps that a block moves outwards for an expansion of 1.
double outward_steps(int block_index, const ExpansionModel& model) {
  const double middle = (block_index + 0.5) * model.block - model.zero_step;
  const double sine = std::sin(middle / model.focal_px);
  return model.focal_px * sine * std::abs(sine);
}

void add_shifted(const std::int32_t* from, std::vector<std::int32_t>& to) {
  std::int32_t* out = to.data();
  for (std::size_t i = 0; i < to.size(); ++i) out[i] += from[i];
}

}  // namespace

void ExpandingShiftFinder::fill_block_table(const Profile& previous, const Profile& current, int block) {
  const int size = static_cast<int>(previous.size()), blocks = size / block;
  const int shifts = 2 * reach_ + 1;
  block_sums_.assign(static_cast<std::size_t>(blocks * shifts), 0);
  block_counts_.assign(static_cast<std::size_t>(blocks * shifts), 0);
  for (int b = 0; b < blocks; ++b) {
    for (int d = -reach_; d <= reach_; ++d) {
      const int first = std::max(b * block, -d), end = std::min((b + 1) * block, size - d);
      // A narrow strip of a block fits anywhere.
      if (2 * (end - first) < block) continue;
      const auto at = static_cast<std::size_t>(b * shifts + d + reach_);
      block_sums_[at] = static_cast<std::int32_t>(
          sum_of_differences(current.data() + first + d, previous.data() + first, end - first));
      block_counts_[at] = end - first;
    }
  }
}

void ExpandingShiftFinder::search_side(int first_block, int end_block, int max_shift, const ExpansionModel& model,
                                       Side& side) {
  const auto shifts = static_cast<std::size_t>(2 * max_shift + 1);
  side.sums.assign(shifts, 0);
  side.counts.assign(shifts, 0);
  side.expansions.assign(shifts, 0.0);
  for (int step = 0; step <= model.expansions; ++step) {
    const double expansion = model.max_expansion * step / std::max(1, model.expansions);
    sums_.assign(shifts, 0);
    counts_.assign(shifts, 0);
    for (int b = first_block; b < end_block; ++b) {
      const int outward = static_cast<int>(std::lround(expansion * outward_steps(b, model)));
      const int offset = std::clamp(outward, max_shift - reach_, reach_ - max_shift);
      const auto at = static_cast<std::ptrdiff_t>(b) * (2 * reach_ + 1) + reach_ - max_shift + offset;
      add_shifted(block_sums_.data() + at, sums_);
      add_shifted(block_counts_.data() + at, counts_);
    }
    for (std::size_t i = 0; i < shifts; ++i) {
      // Compares means without a division; a side without overlap loses against any other.
      const auto mine = std::int64_t{sums_[i]} * side.counts[i], best = std::int64_t{side.sums[i]} * counts_[i];
      if (counts_[i] == 0 || (side.counts[i] != 0 && mine >= best)) continue;
      side.sums[i] = sums_[i];
      side.counts[i] = counts_[i];
      side.expansions[i] = expansion;
    }
  }
}

ExpandingShift ExpandingShiftFinder::find(const Profile& previous, const Profile& current, int max_shift,
                                          const ExpansionModel& model) {
  RASTRO_CHECK(previous.size() == current.size(), "profiles of one length");
  RASTRO_CHECK(model.block > 0 && model.focal_px > 0.0, "blocks and steps must be positive");
  const int size = static_cast<int>(previous.size()), blocks = size / model.block;
  max_shift = std::min(max_shift, size / 2);
  if (max_shift < 1 || blocks < 2) return {};
  const double farthest = std::max(std::abs(outward_steps(0, model)), std::abs(outward_steps(blocks - 1, model)));
  reach_ = max_shift + static_cast<int>(std::lround(model.max_expansion * farthest));
  fill_block_table(previous, current, model.block);
  const int middle = std::clamp((model.zero_step + model.block / 2) / model.block, 0, blocks);
  search_side(0, middle, max_shift, model, low_);
  search_side(middle, blocks, max_shift, model, high_);

  std::vector<double> p(low_.sums.size(), 255.0);
  for (std::size_t i = 0; i < p.size(); ++i) {
    const int count = low_.counts[i] + high_.counts[i];
    if (count > 0) p[i] = static_cast<double>(low_.sums[i] + high_.sums[i]) / count / profile_units;
  }
  ExpandingShift result{lowest_of(p)};
  const auto best = static_cast<std::size_t>(std::lround(result.shift) + max_shift);
  result.low_expansion = low_.expansions[std::min(best, p.size() - 1)];
  result.high_expansion = high_.expansions[std::min(best, p.size() - 1)];
  return result;
}

}  // namespace rastro
