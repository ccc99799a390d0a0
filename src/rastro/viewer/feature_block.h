// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <nlohmann/json.hpp>

#include "rastro/viewer/block_writer.h"
#include "rastro/viewer/live_messages.h"

namespace rastro::detail {

/// The features of an image, as in all blocks that have some.
void put_features(const LiveFeatures& features, nlohmann::ordered_json& header, BlockBody& body);

}  // namespace rastro::detail
