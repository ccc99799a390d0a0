// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/map/layer_type.h"

namespace rastro {

/// A layer with at most one immutable item per keyframe.
template <typename Thing>
struct KeyframeLayer : Layer {
  std::map<KeyframeId, std::shared_ptr<const Thing>> of;

  /// Null where the keyframe has none.
  const Thing* find(KeyframeId id) const {
    const auto found = of.find(id);
    return found == of.end() ? nullptr : found->second.get();
  }
};

/// The common part of such layers: a derived class defines how an item is serialized and described.
template <typename L, typename Thing>
class KeyframeLayerType : public LayerType {
 public:
  std::string name() const override { return L::layer_name; }

  virtual std::string body_of(const Thing& thing) const = 0;
  virtual std::shared_ptr<const Thing> thing_of(KeyframeId id, std::string_view body,
                                                const std::string& where) const = 0;

  std::vector<std::int64_t> rows(const Layer& layer) const override {
    std::vector<std::int64_t> ids;
    for (const auto& [id, thing] : typed(layer).of) ids.push_back(id);
    return ids;
  }
  std::string row(const Layer& layer, std::int64_t id) const override { return body_of(*typed(layer).of.at(id)); }
  bool same_row(const Layer& before, const Layer& now, std::int64_t id) const override {
    return typed(before).of.at(id) == typed(now).of.at(id);
  }
  std::shared_ptr<Layer> make(std::string_view, const std::string&) const override { return std::make_shared<L>(); }
  void read(Layer& layer, std::int64_t id, std::string_view body, const std::string& where) const override {
    static_cast<L&>(layer).of[id] = thing_of(id, body, where);
  }
  std::string contradiction(const Map& map, const Layer& layer) const override {
    for (const auto& [id, thing] : typed(layer).of)
      if (!map.index_of(id)) return "has " + name() + " of a keyframe that is not there";
    return {};
  }
  std::shared_ptr<const Layer> repaired(const Map& map, const std::shared_ptr<const Layer>& layer) const override {
    auto kept = std::make_shared<L>(typed(*layer));
    std::erase_if(kept->of, [&](const auto& each) { return !map.index_of(each.first); });
    return kept;
  }
  LayerCut cut(const Layer& layer, KeyframeId id) const override {
    const Thing* thing = typed(layer).find(id);
    auto rest = std::make_shared<L>(typed(layer));
    rest->of.erase(id);
    return {std::move(rest), thing ? body_of(*thing) : std::string()};
  }
  std::shared_ptr<const Layer> paste(const Layer& layer, KeyframeId id, std::string_view bytes) const override {
    auto whole = std::make_shared<L>(typed(layer));
    if (!bytes.empty()) whole->of[id] = thing_of(id, bytes, name());
    return whole;
  }

  std::shared_ptr<const Layer> renumbered(const std::shared_ptr<const Layer>& layer,
                                          const std::map<KeyframeId, KeyframeId>& new_id) const override {
    auto result = std::make_shared<L>(typed(*layer));
    result->of.clear();
    for (const auto& [id, thing] : typed(*layer).of) result->of[new_id.at(id)] = with_id(thing, new_id.at(id));
    return result;
  }

 protected:
  /// The same item with another id, for items that store the id of their keyframe.
  virtual std::shared_ptr<const Thing> with_id(const std::shared_ptr<const Thing>& thing, KeyframeId) const {
    return thing;
  }
  static const L& typed(const Layer& layer) { return static_cast<const L&>(layer); }
};

}  // namespace rastro
