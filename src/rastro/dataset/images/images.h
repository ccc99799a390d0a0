// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/dataset/recording.h"

namespace rastro {

/// Stamps from file names that rise and all are whole numbers of 13 digits or more, whose unit is guessed from all of
/// them (1403715285262142976.png is in nanoseconds, 1418381798086398.png in microseconds), or seconds with a fraction
/// (1305031102.175304.png); nullopt where any is not.
std::optional<std::vector<TimeNs>> stamps_from_names(const std::vector<std::string>& names);

/// A folder of images, a glob ("dir/left*.jpg") or one image, in natural order. nullopt where `path` is nothing of the
/// kind.
std::optional<Recording> index_images(const std::string& path, const OpenOptions& options);

}  // namespace rastro
