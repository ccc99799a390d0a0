// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace rastro {

/// A block of scene_bytes(), read as the page reads it; keeps a copy.
class SceneBlock {
 public:
  using Json = nlohmann::json;

  explicit SceneBlock(std::string_view bytes) {
    std::uint32_t length = 0;
    if (bytes.size() < sizeof length) throw std::runtime_error("no length");
    std::memcpy(&length, bytes.data(), sizeof length);
    if ((sizeof length + length) % 8 != 0 || sizeof length + length > bytes.size())
      throw std::runtime_error("bad length");
    header = Json::parse(bytes.substr(sizeof length, length));
    body_ = bytes.substr(sizeof length + length);
  }

  template <typename Number>
  std::vector<Number> numbers(const Json& reference) const {
    const auto offset = reference.at("offset").get<std::size_t>(), count = reference.at("count").get<std::size_t>();
    if (reference.at("type") != type_of(Number())) throw std::runtime_error("another type");
    if (offset % 8 != 0 || offset + count * sizeof(Number) > body_.size()) throw std::runtime_error("outside");
    std::vector<Number> result(count);
    if (count > 0) std::memcpy(result.data(), body_.data() + offset, count * sizeof(Number));
    return result;
  }
  /// nullptr where there is none.
  const Json* layer(const std::string& name) const {
    for (const Json& each : header.at("layers"))
      if (each.at("name") == name) return &each;
    return nullptr;
  }
  std::vector<std::string> layer_names() const {
    std::vector<std::string> names;
    for (const Json& each : header.at("layers")) names.push_back(each.at("name"));
    return names;
  }

  Json header;

 private:
  static const char* type_of(float) { return "f32"; }
  static const char* type_of(double) { return "f64"; }
  static const char* type_of(std::uint8_t) { return "u8"; }
  static const char* type_of(std::uint32_t) { return "u32"; }
  static const char* type_of(std::int32_t) { return "i32"; }
  std::string body_;
};

}  // namespace rastro
