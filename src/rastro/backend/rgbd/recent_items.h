// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

namespace rastro {

/// The most recently used of what can be made again. Thread-safe.
template <typename Item>
class RecentItems {
 public:
  explicit RecentItems(std::size_t most) : most_(most) {}

  /// Null if it is not there.
  std::shared_ptr<const Item> find(std::int64_t id) {
    const std::lock_guard lock(mutex_);
    const auto found = items_.find(id);
    if (found == items_.end()) return nullptr;
    found->second.last_use = ++uses_;
    return found->second.item;
  }

  std::shared_ptr<const Item> add(std::int64_t id, Item item) {
    auto shared = std::make_shared<const Item>(std::move(item));
    const std::lock_guard lock(mutex_);
    items_[id] = {shared, ++uses_};
    if (items_.size() > most_)
      items_.erase(std::min_element(items_.begin(), items_.end(), [](const auto& a, const auto& b) {
        return a.second.last_use < b.second.last_use;
      }));
    return shared;
  }

  void clear() {
    const std::lock_guard lock(mutex_);
    items_.clear();
  }

 private:
  struct Held {
    std::shared_ptr<const Item> item;
    std::uint64_t last_use = 0;
  };
  std::size_t most_;
  std::mutex mutex_;
  std::map<std::int64_t, Held> items_;
  std::uint64_t uses_ = 0;
};

}  // namespace rastro
