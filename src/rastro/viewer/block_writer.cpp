// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/block_writer.h"

#include "rastro/base/error.h"

namespace rastro::detail {

std::string text_of(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string block_of(const nlohmann::ordered_json& header, const BlockBody& body) {
  constexpr std::size_t length_bytes = sizeof(std::uint32_t), alignment = BlockBody::alignment;
  std::string text = text_of(header);
  text.resize((length_bytes + text.size() + alignment - 1) / alignment * alignment - length_bytes, ' ');
  RASTRO_CHECK(text.size() < (std::size_t{1} << 31), "the header of a block is small");
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string bytes(reinterpret_cast<const char*>(&length), length_bytes);
  bytes.reserve(length_bytes + text.size() + body.bytes().size());
  return bytes.append(text).append(body.bytes());
}

}  // namespace rastro::detail
