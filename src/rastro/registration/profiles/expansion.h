// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/registration/profiles/profile.h"
#include "rastro/registration/profiles/shift.h"

namespace rastro {

/// Model of the profile for a camera that moves forward by t between walls at lateral distances X: wall points move
/// outwards by (t / X) sin^2(angle), whatever their depth along the path. The same holds above and below for ground and
/// ceiling.
struct ExpansionModel {
  double focal_px = 500.0;     ///< One step of the profiles is 1 / focal_px radians.
  int zero_step = 0;           ///< The step straight ahead.
  double max_expansion = 0.2;  ///< Largest t / X of the search.
  int expansions = 20;         ///< Values tried on each side, besides zero.
  int block = 64;              ///< Steps that move together.
};

struct ExpandingShift : ProfileShift {
  double low_expansion = 0.0;   ///< t / X on the side of the lower indices.
  double high_expansion = 0.0;  ///< On the other.
};

/// As find_shift(), but each side of the profile may also expand, so that passing walls are not mistaken for a
/// rotation. Both profiles must be resampled by an AngleScale. Exhaustive, hence never caught in a local minimum.
class ExpandingShiftFinder {
 public:
  ExpandingShift find(const Profile& previous, const Profile& current, int max_shift, const ExpansionModel& model);

 private:
  struct Side {
    std::vector<std::int32_t> sums, counts;  ///< Of the best expansion, one per shift.
    std::vector<double> expansions;
  };
  void fill_block_table(const Profile& previous, const Profile& current, int block);
  void search_side(int first_block, int end_block, int max_shift, const ExpansionModel& model, Side& side);

  int reach_ = 0;                                        ///< Largest shift of the block table.
  std::vector<std::int32_t> block_sums_, block_counts_;  ///< [block][shift + reach_]
  std::vector<std::int32_t> sums_, counts_;              ///< Scratch: one per shift.
  Side low_, high_;
};

}  // namespace rastro
