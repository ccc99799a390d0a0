// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/map/layer_type.h"

namespace rastro {

/// Items of keyframes that are too large to be all in memory: in a map file, read on demand, or in memory after all.
/// Thread-safe.
template <typename Item>
class ItemStore {
 public:
  virtual ~ItemStore() = default;
  /// Error where it cannot be read.
  virtual Item read(KeyframeId keyframe) const = 0;
};

/// Items in memory. Thread-safe.
template <typename Item>
class MemoryItems : public ItemStore<Item> {
 public:
  void add(KeyframeId keyframe, Item item) {
    const std::lock_guard lock(mutex_);
    items_[keyframe] = std::move(item);
  }
  Item read(KeyframeId keyframe) const override {
    const std::lock_guard lock(mutex_);
    const auto found = items_.find(keyframe);
    if (found == items_.end())
      throw Error("is missing in the map", "keyframe " + std::to_string(keyframe),
                  "the map was not made by this program");
    return found->second;
  }

 private:
  mutable std::mutex mutex_;
  std::map<KeyframeId, Item> items_;
};

/// A layer with at most one item per keyframe, read on demand.
template <typename Item>
struct StoredLayer : Layer {
  std::shared_ptr<const ItemStore<Item>> store;
  std::vector<KeyframeId> keyframes;  ///< Those that have an item; ascending.
};

/// The common part of such layers: a derived class defines how an item is serialized and described.
template <typename L, typename Item>
class StoredLayerType : public LayerType {
 public:
  std::string name() const override { return L::layer_name; }
  virtual std::string body_of(const Item& item) const = 0;
  virtual Item item_of(std::string_view body, const std::string& where) const = 0;

  std::vector<std::int64_t> rows(const Layer& layer) const override { return typed(layer).keyframes; }
  std::string row(const Layer& layer, std::int64_t id) const override { return body_of(typed(layer).store->read(id)); }
  bool same_row(const Layer&, const Layer&, std::int64_t) const override { return true; }
  bool stays_in_file() const override { return true; }

  std::shared_ptr<Layer> make(std::string_view, const std::string&) const override {
    auto layer = std::make_shared<L>();
    layer->store = std::make_shared<MemoryItems<Item>>();
    return layer;
  }
  void attach(Layer& layer, std::shared_ptr<const RowStore> rows) const override {
    static_cast<L&>(layer).store = in_file(std::move(rows));
  }
  /// The items of a map file.
  std::shared_ptr<const ItemStore<Item>> in_file(std::shared_ptr<const RowStore> rows) const {
    return std::make_shared<Stored>(*this, std::move(rows));
  }
  /// With an attached file, only the id is used.
  void read(Layer& layer, std::int64_t id, std::string_view body, const std::string& where) const override {
    auto& own = static_cast<L&>(layer);
    own.keyframes.push_back(id);
    if (body.empty()) return;
    const auto memory = std::dynamic_pointer_cast<const MemoryItems<Item>>(own.store);
    if (memory) std::const_pointer_cast<MemoryItems<Item>>(memory)->add(id, item_of(body, where));
  }

  std::string contradiction(const Map& map, const Layer& layer) const override {
    const std::vector<KeyframeId>& keyframes = typed(layer).keyframes;
    if (!std::is_sorted(keyframes.begin(), keyframes.end())) return "has " + name() + " out of order";
    for (const KeyframeId id : keyframes)
      if (!map.index_of(id)) return "has " + name() + " of a keyframe that is not there";
    return {};
  }
  std::shared_ptr<const Layer> repaired(const Map& map, const std::shared_ptr<const Layer>& layer) const override {
    auto kept = std::make_shared<L>(typed(*layer));
    std::erase_if(kept->keyframes, [&](KeyframeId id) { return !map.index_of(id); });
    return kept;
  }

  LayerCut cut(const Layer& layer, KeyframeId id) const override {
    auto rest = std::make_shared<L>(typed(layer));
    const bool there = std::erase(rest->keyframes, id) > 0;
    return {std::move(rest), there ? row(layer, id) : std::string()};
  }
  std::shared_ptr<const Layer> paste(const Layer& layer, KeyframeId id, std::string_view bytes) const override {
    auto whole = std::make_shared<L>(typed(layer));
    if (bytes.empty()) return whole;
    whole->store = std::make_shared<AndOne>(whole->store, id, item_of(bytes, name()));
    const auto at = std::lower_bound(whole->keyframes.begin(), whole->keyframes.end(), id);
    if (at == whole->keyframes.end() || *at != id) whole->keyframes.insert(at, id);
    return whole;
  }

  std::shared_ptr<const Layer> renumbered(const std::shared_ptr<const Layer>& layer,
                                          const std::map<KeyframeId, KeyframeId>& new_id) const override {
    auto result = std::make_shared<L>(typed(*layer));
    std::map<KeyframeId, KeyframeId> old_id;
    for (KeyframeId& id : result->keyframes) {
      old_id[new_id.at(id)] = id;
      id = new_id.at(id);
    }
    result->store = std::make_shared<Renumbered>(result->store, std::move(old_id));
    return result;
  }

 protected:
  static const L& typed(const Layer& layer) { return static_cast<const L&>(layer); }

 private:
  /// Items that stay in a map file. Layer types live as long as the program.
  class Stored : public ItemStore<Item> {
   public:
    Stored(const StoredLayerType& type, std::shared_ptr<const RowStore> rows) : type_(type), rows_(std::move(rows)) {}
    Item read(KeyframeId keyframe) const override {
      return type_.item_of(rows_->row(keyframe), type_.name() + " of keyframe " + std::to_string(keyframe));
    }

   private:
    const StoredLayerType& type_;
    std::shared_ptr<const RowStore> rows_;
  };

  /// The same items under other ids.
  class Renumbered : public ItemStore<Item> {
   public:
    Renumbered(std::shared_ptr<const ItemStore<Item>> items, std::map<KeyframeId, KeyframeId> old_id)
        : items_(std::move(items)), old_id_(std::move(old_id)) {}
    Item read(KeyframeId keyframe) const override { return items_->read(old_id_.at(keyframe)); }

   private:
    std::shared_ptr<const ItemStore<Item>> items_;
    std::map<KeyframeId, KeyframeId> old_id_;
  };

  /// A store with the item of one additional keyframe.
  class AndOne : public ItemStore<Item> {
   public:
    AndOne(std::shared_ptr<const ItemStore<Item>> others, KeyframeId id, Item own)
        : others_(std::move(others)), id_(id), own_(std::move(own)) {}
    Item read(KeyframeId keyframe) const override {
      return keyframe == id_ || !others_ ? own_ : others_->read(keyframe);
    }

   private:
    std::shared_ptr<const ItemStore<Item>> others_;
    KeyframeId id_;
    Item own_;
  };
};

}  // namespace rastro
