// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "rastro/evaluate/length_objects.h"
#include "rastro/evaluate/map_lengths.h"
#include "rastro/map/graph/map.h"

namespace rastro::cli {

/// A map of arbitrary scale, and the points in its unit, nearly in meters: by the rough points of the known length.
/// Others as they are. Error naming `where` if the scale is arbitrary and no length is known.
std::tuple<std::shared_ptr<const Map>, std::vector<LengthObject>> roughly_metric(std::shared_ptr<const Map> map,
                                                                                 std::vector<LengthObject> objects,
                                                                                 const std::string& known,
                                                                                 const std::string& where);

/// Scales the lengths by the known one and takes it out; a note on each says so where it was not measured.
void apply_known_length(std::vector<MeasuredLength>& lengths, const std::string& known);

}  // namespace rastro::cli
