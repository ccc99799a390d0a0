// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/feature_block.h"

namespace rastro::detail {

void put_features(const LiveFeatures& features, nlohmann::ordered_json& header, BlockBody& body) {
  header["features"] = body.put(features.pixels);
  header["feature_states"] = body.put(features.states);
  header["feature_state_names"] = features.state_names;
  body.put_if_any(header, "feature_ids", features.ids);
  body.put_if_any(header, "trail_lengths", features.trail_lengths);
  body.put_if_any(header, "trails", features.trails);
  body.put_if_any(header, "feature_colors", features.colors);
}

}  // namespace rastro::detail
