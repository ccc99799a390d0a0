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

/// Statistics of one length over several maps, as in tables of papers. Meters.
struct LengthSummary {
  std::string name;
  std::optional<double> true_length_m;
  int maps = 0, measured = 0;
  double mean_m = 0.0;  ///< Of the measurements.
  double mean_sigma_m = 0.0;
  std::optional<double> mean_error_m, max_error_m;  ///< Of the absolute errors; none without ground truth.
  std::optional<double> rms_sigmas;  ///< Root mean square of error by sigma: about 1 if the sigmas are consistent.
};

/// In the order of the first map's lengths; the same lengths must have been measured in all maps.
std::vector<LengthSummary> summarize_lengths(const std::vector<MapOfLengths>& maps);

/// As text: a table for each map and, with several, one over all.
std::string lengths_as_text(const std::vector<MapOfLengths>& maps);
/// As JSON: every measurement of every map, and the summary; null for missing values.
std::string lengths_as_json(const std::vector<MapOfLengths>& maps);
/// As CSV: one line per measurement.
std::string lengths_as_csv(const std::vector<MapOfLengths>& maps);

/// Figures for limits: measured (share of all), mean_error_m, max_error_m, max_error_percent, max_sigma_m, rms_sigmas;
/// NaN if nothing with a true length was measured.
std::vector<std::pair<std::string, double>> length_figures(const std::vector<MapOfLengths>& maps);

}  // namespace rastro
