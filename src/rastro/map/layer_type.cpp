// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/layer_type.h"

namespace rastro {

const LayerType* layer_type(std::string_view name) {
  for (const auto& type : layer_types())
    if (type->name() == name) return type.get();
  return nullptr;
}

PointCloud layer_points(const Map& map, int submap, std::size_t most) {
  PointCloud cloud;
  for (const auto& [name, layer] : map.layers.all())
    if (const LayerType* type = layer_type(name)) type->add_points(map, *layer, submap, most, cloud);
  return cloud;
}

}  // namespace rastro
