// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/paper_table.h"

namespace rastro::cli {

/// The lengths that the comparison paper measured in maps of a room by hand, its tables 1 and 2.
struct PublishedLength {
  std::string world;  ///< Of 'rastro simulate': a room with these lengths.
  std::string name;   ///< In the objects.yaml of the world.
  double true_m = 0.0;
  struct Measured {
    std::string method;
    double mean_m = 0.0, max_error_m = 0.0;
  };
  std::vector<Measured> measured;  ///< rtabmap, orb, lsd, rgbd.
};
const std::vector<PublishedLength>& published_lengths();

/// One per input that is a world of published_lengths(), over its seeds and repeats. Head: length, method, maps, mean
/// [m], max error [m], paper's mean [m], paper's max error [m].
std::vector<PaperTable> paper_length_tables(const Comparison& comparison);

}  // namespace rastro::cli
