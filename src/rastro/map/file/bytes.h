// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "rastro/base/error.h"

namespace rastro {

static_assert(std::endian::native == std::endian::little, "map files are little-endian");

[[noreturn]] inline void refuse_damaged(const std::string& where, std::string_view what = "is damaged") {
  throw Error(what, where, "'rastro recover' saves what can be read");
}

/// Writes numbers and text one after the other, little-endian.
class ByteWriter {
 public:
  template <typename Number>
  void put(Number number) {
    static_assert(std::is_arithmetic_v<Number>);
    put_raw(&number, sizeof number);
  }
  void put_raw(const void* from, std::size_t size) {
    if (size > 0) bytes_.append(static_cast<const char*>(from), size);
  }
  void put_text(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    bytes_.append(text);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads them back. Throws Error naming `where` for bytes that end too early, numbers that are not finite and bytes
/// left over.
class ByteReader {
 public:
  ByteReader(std::string_view bytes, const std::string& where) : bytes_(bytes), where_(where) {}

  template <typename Number>
  Number get() {
    static_assert(std::is_arithmetic_v<Number>);
    Number number;
    std::memcpy(&number, raw(sizeof number).data(), sizeof number);
    if constexpr (std::is_floating_point_v<Number>) check(std::isfinite(number));
    return number;
  }
  std::string_view raw(std::size_t size) {
    check(size <= bytes_.size());
    const std::string_view piece = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return piece;
  }
  std::string_view text() { return raw(get<std::uint32_t>()); }
  /// Number of items of `item_size` bytes that follow; never more than the remaining bytes can hold.
  std::size_t count(std::size_t item_size) {
    const std::size_t items = get<std::uint32_t>();
    check(items <= bytes_.size() / item_size);
    return items;
  }
  void check(bool sound) const {
    if (!sound) refuse_damaged(where_);
  }
  void finish() const { check(bytes_.empty()); }
  std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
  const std::string& where_;
};

}  // namespace rastro
