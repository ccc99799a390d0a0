// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace rastro {

/// Objects by ids that ascend from 0 as they are added. Their addresses stay. The ids of removed objects take no memory
/// once all of their block are removed, so that a table with as many new ids as removed ones does not grow.
template <typename T>
class IdTable {
 public:
  /// One more than the largest id ever added.
  std::int64_t end_id() const { return end_; }
  /// Null: never added, or removed.
  T* find(std::int64_t id) const {
    if (id < 0 || id >= end_) return nullptr;
    const Block* block = blocks_[static_cast<std::size_t>(id / block_size)].get();
    return block == nullptr ? nullptr : block->objects[static_cast<std::size_t>(id % block_size)].get();
  }
  /// `id` must be at least end_id().
  T& add(std::int64_t id, std::unique_ptr<T> object) {
    end_ = id + 1;
    const auto number = static_cast<std::size_t>(id / block_size);
    if (number >= blocks_.size()) blocks_.resize(number + 1);
    if (!blocks_[number]) blocks_[number] = std::make_unique<Block>();
    auto& slot = blocks_[number]->objects[static_cast<std::size_t>(id % block_size)];
    slot = std::move(object);
    ++blocks_[number]->used;
    return *slot;
  }
  /// Does nothing where find() gives null.
  void remove(std::int64_t id) {
    if (find(id) == nullptr) return;
    std::unique_ptr<Block>& block = blocks_[static_cast<std::size_t>(id / block_size)];
    block->objects[static_cast<std::size_t>(id % block_size)].reset();
    // The newest block is kept: ids are still to come.
    if (--block->used == 0 && end_ / block_size > id / block_size) block.reset();
  }
  /// Calls f(T&) in the order of the ids.
  template <typename F>
  void for_each(const F& f) const {
    for (const auto& block : blocks_) {
      if (!block) continue;
      for (const auto& object : block->objects) {
        if (object) f(*object);
      }
    }
  }

 private:
  static constexpr std::int64_t block_size = 16;  ///< Small: a block stays while one of its objects does.
  struct Block {
    std::array<std::unique_ptr<T>, block_size> objects;
    int used = 0;
  };
  std::vector<std::unique_ptr<Block>> blocks_;
  std::int64_t end_ = 0;
};

}  // namespace rastro
