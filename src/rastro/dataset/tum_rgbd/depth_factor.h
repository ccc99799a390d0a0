// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/image/image.h"

namespace rastro {

struct DepthFactor {
  double units_per_meter = 5000.0;
  std::string reason;  ///< One clause: how it was found.
  bool is_a_guess = true;
  double offset_m = 0.0;  ///< To be added to each depth.
};

/// Looks for a line such as "depth_factor: 5000", "DepthMapFactor: 5000", "m_depthShift = 1000" in a text; nullopt
/// where none is. Error naming `where`:line where the value is no positive number.
std::optional<double> parse_depth_factor(std::string_view text, std::string_view where);

/// The same for "depth_offset_m: -0.004", at most 1 m either way; 0 where there is none.
double parse_depth_offset(std::string_view text, std::string_view where);

/// From the numbers themselves. The Kinect measures whole millimeters, so numbers that are nearly all multiples of 5
/// were written at 5000 a meter; 65535 as "none", or a scene that would be no deeper than 2.4 m at 5000 a meter, means
/// millimeters.
DepthFactor guess_depth_factor(std::span<const Image<std::uint16_t>> images);

/// From a calibration or info file; nullopt where it does not say.
std::optional<DepthFactor> read_depth_factor(const std::filesystem::path& file);

/// From a calibration or info file in the folder; nullopt where none says it.
std::optional<DepthFactor> depth_factor_in(const std::filesystem::path& folder);

/// From up to five of the depth images.
DepthFactor guess_depth_factor_of(const std::vector<std::string>& depth_files);

}  // namespace rastro
