// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/evaluate/map_lengths.h"

namespace rastro {

/// The lengths of one map.
struct MapOfLengths {
  std::string map;  ///< As given.
  std::vector<MeasuredLength> lengths;
};

/// One length over several maps, as tables of papers have it. Metres.
struct LengthSummary {
  std::string name;
  std::optional<double> true_length_m;
  int maps = 0, measured = 0;
  double mean_m = 0.0;  ///< Of the measures.
  double mean_sigma_m = 0.0;
  std::optional<double> mean_error_m, max_error_m;  ///< Of the absolute errors; none without truth.
  std::optional<double> rms_sigmas;  ///< Root mean square of error by sigma: about 1 where the sigmas are honest.
};

/// In the order of the first map's lengths; all maps were asked for the same ones.
std::vector<LengthSummary> summarise_lengths(const std::vector<MapOfLengths>& maps);

/// For people: a table for each map and, where there are several, one over all.
std::string lengths_as_text(const std::vector<MapOfLengths>& maps);
/// For programs: every measure of every map, and the summary; null where there is nothing to tell.
std::string lengths_as_json(const std::vector<MapOfLengths>& maps);
/// A line for each measure.
std::string lengths_as_csv(const std::vector<MapOfLengths>& maps);

/// What limits may be put on: measured (share of all), mean_error_m, max_error_m, max_error_percent, max_sigma_m,
/// rms_sigmas; not a number where nothing with a truth was measured.
std::vector<std::pair<std::string, double>> length_figures(const std::vector<MapOfLengths>& maps);

}  // namespace rastro
