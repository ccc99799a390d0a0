// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/report_text.h"

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

/// A table of a publication beside ours.
struct PaperTable {
  std::string title;
  TextRows rows;  ///< Head: length, method, maps, mean [m], max error [m], paper's mean [m], paper's max error [m].
};
/// One per input that is a world of published_lengths(), over its seeds and repeats.
std::vector<PaperTable> paper_tables(const Comparison& comparison);

/// The words of 'rastro compare' for the same methods on the same rooms.
std::vector<std::string> paper_inputs();
std::vector<std::string> paper_methods();

/// What ours and theirs do not have in common.
constexpr const char* paper_note =
    "The paper's ORB- and LSD-SLAM saw with one camera, its maps were measured by hand; ours see with the depth "
    "camera, "
    "and 'rastro measure' measures. The rooms are generated, with the paper's lengths.";

}  // namespace rastro::cli
