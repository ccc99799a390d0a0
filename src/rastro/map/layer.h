// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace rastro {

/// One kind of content that keyframes carry. Immutable once it is part of a map. A derived class has a member `static
/// constexpr const char* layer_name` and a LayerType (map/layer_type.h).
class Layer {
 public:
  virtual ~Layer() = default;
};

/// The layers of a map by name, at most one of each.
class LayerSet {
 public:
  using Layers = std::map<std::string, std::shared_ptr<const Layer>, std::less<>>;

  /// Null where the map has none.
  template <typename L>
  std::shared_ptr<const L> get() const {
    return std::dynamic_pointer_cast<const L>(find(L::layer_name));
  }
  template <typename L>
  void put(std::shared_ptr<const L> layer) {
    put(L::layer_name, std::move(layer));
  }
  std::shared_ptr<const Layer> find(std::string_view name) const {
    const auto found = layers_.find(name);
    return found == layers_.end() ? nullptr : found->second;
  }
  /// A null pointer removes the layer.
  void put(const std::string& name, std::shared_ptr<const Layer> layer) {
    if (layer) {
      layers_[name] = std::move(layer);
    } else {
      layers_.erase(name);
    }
  }
  const Layers& all() const { return layers_; }

 private:
  Layers layers_;
};

}  // namespace rastro
