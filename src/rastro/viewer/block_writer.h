// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace rastro::detail {

/// The arrays behind the header of a block, as README.md describes it.
class BlockBody {
 public:
  static constexpr std::size_t alignment = 8;  ///< Of every array, so that the page can view them in place.

  /// The reference to the array for the header.
  template <typename Number>
  nlohmann::ordered_json put(const std::vector<Number>& numbers) {
    static_assert(std::endian::native == std::endian::little, "arrays are little endian");
    const std::size_t offset = bytes_.size();
    bytes_.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number));
    bytes_.resize((bytes_.size() + alignment - 1) / alignment * alignment, '\0');
    return {{"offset", offset}, {"type", type_name<Number>()}, {"count", numbers.size()}};
  }
  /// Adds the array to an object, unless it is empty.
  template <typename Number>
  void put_if_any(nlohmann::ordered_json& object, const char* name, const std::vector<Number>& numbers) {
    if (!numbers.empty()) object[name] = put(numbers);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  template <typename Number>
  static constexpr const char* type_name() {
    if constexpr (std::is_same_v<Number, float>) return "f32";
    if constexpr (std::is_same_v<Number, double>) return "f64";
    if constexpr (std::is_same_v<Number, std::uint8_t>) return "u8";
    if constexpr (std::is_same_v<Number, std::uint32_t>) return "u32";
    if constexpr (std::is_same_v<Number, std::int32_t>) return "i32";
  }

  std::string bytes_;
};

/// Length of the header, header, body.
std::string block_of(const nlohmann::ordered_json& header, const BlockBody& body);

/// One line of JSON. Names of files may be no UTF-8: what is none is replaced.
std::string text_of(const nlohmann::ordered_json& json);

}  // namespace rastro::detail
