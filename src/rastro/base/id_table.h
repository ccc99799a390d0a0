// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace rastro {

/// Objects by ids that ascend from 0 as they are added. Their addresses stay. A removed one leaves a quarter of a byte
/// behind, wherever it was: in a map of one place ids go on for as long as the run, and those that stay are few and far
/// between.
template <typename T>
class IdTable {
 public:
  /// One more than the largest id ever added.
  std::int64_t end_id() const { return end_; }
  /// Null: never added, or removed.
  T* find(std::int64_t id) const {
    if (id < 0 || id >= end_) return nullptr;
    const Block& block = blocks_[number_of(id)];
    return (block.used & bit_of(id)) == 0 ? nullptr : block.objects[block.before(id)].get();
  }
  /// `id` must be at least end_id().
  T& add(std::int64_t id, std::unique_ptr<T> object) {
    end_ = id + 1;
    if (number_of(id) >= blocks_.size()) blocks_.resize(number_of(id) + 1);
    Block& block = blocks_[number_of(id)];
    const std::size_t count = block.count();
    block.change_room(count, room_for(count), room_for(count + 1));
    block.used |= bit_of(id);
    return *(block.objects[count] = std::move(object));  // the last one: ids ascend
  }
  /// Does nothing where find() gives null.
  void remove(std::int64_t id) {
    if (find(id) == nullptr) return;
    Block& block = blocks_[number_of(id)];
    const std::size_t count = block.count(), at = block.before(id);
    std::unique_ptr<T>* const objects = block.objects.get();
    std::move(objects + at + 1, objects + count, objects + at);
    objects[count - 1].reset();  // it was the last one itself, or this one has been moved
    block.used &= ~bit_of(id);
    block.change_room(count - 1, room_for(count), room_for(count - 1));
  }
  /// Calls f(T&) in the order of the ids; f must not add or remove.
  template <typename F>
  void for_each(const F& f) const {
    for (const Block& block : blocks_)
      for (std::size_t k = 0; k < block.count(); ++k) f(*block.objects[k]);
  }

  /// Without the objects themselves.
  std::size_t bytes() const {
    std::size_t bytes = blocks_.capacity() * sizeof(Block);
    for (const Block& block : blocks_) bytes += room_for(block.count()) * sizeof(std::unique_ptr<T>);
    return bytes;
  }

 private:
  static constexpr std::int64_t block_size = 64;  ///< The bits of a number.
  static std::size_t number_of(std::int64_t id) { return static_cast<std::size_t>(id / block_size); }
  static std::uint64_t bit_of(std::int64_t id) { return std::uint64_t{1} << (id % block_size); }

  static std::size_t room_for(std::size_t count) { return count == 0 ? 0 : std::bit_ceil(count); }

  /// The objects of block_size ids, without gaps.
  struct Block {
    std::uint64_t used = 0;                         ///< A bit for each id that has an object.
    std::unique_ptr<std::unique_ptr<T>[]> objects;  ///< Has room_for() them.

    std::size_t count() const { return static_cast<std::size_t>(std::popcount(used)); }
    /// The number of objects with smaller ids.
    std::size_t before(std::int64_t id) const {
      return static_cast<std::size_t>(std::popcount(used & (bit_of(id) - 1)));
    }
    /// With so many objects in it.
    void change_room(std::size_t count, std::size_t from, std::size_t to) {
      if (from == to) return;
      auto room = to == 0 ? nullptr : std::make_unique<std::unique_ptr<T>[]>(to);
      std::move(objects.get(), objects.get() + count, room.get());
      objects = std::move(room);
    }
  };
  std::vector<Block> blocks_;
  std::int64_t end_ = 0;
};

}  // namespace rastro
