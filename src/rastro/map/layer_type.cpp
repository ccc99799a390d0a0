// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/layer_type.h"

namespace rastro {

const LayerType* layer_type(std::string_view name) {
  for (const auto& type : layer_types())
    if (type->name() == name) return type.get();
  return nullptr;
}

}  // namespace rastro
