// SPDX-License-Identifier: Apache-2.0
// Requests to the viewer: whatever the bytes, they get a reply of the rules or none, and without the token never a
// scene.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/viewer/http_message.h"
#include "rastro/viewer/request_rules.h"

namespace {

std::vector<rastro::NamedScene> make_scenes() {
  std::vector<rastro::NamedScene> scenes = {{"first", "FIRST SCENE"}, {"second", "SECOND SCENE"}};
  scenes[1].measure = [](std::string_view query) { return std::string(query); };
  scenes[1].frame_block = [](std::int64_t frame) { return std::to_string(frame); };
  scenes[1].tile_block = [](std::uint64_t layer, std::uint64_t tile) -> std::optional<std::string> {
    return layer < 2 && tile < 9 ? std::optional("TILE") : std::nullopt;
  };
  return scenes;
}

const std::vector<rastro::NamedScene> scenes = make_scenes();

void check(const rastro::detail::RequestRules& rules, std::string_view bytes, bool asks_for_token) {
  const auto reply = rastro::detail::reply_to_bytes(rules, bytes);
  if (!reply) return;
  if (reply->status < 200 || reply->status > 499) __builtin_trap();
  const bool served = reply->status == 200;
  if (served && asks_for_token && bytes.find("s3cret") == std::string_view::npos) __builtin_trap();
  if (served && bytes.find("localhost") == std::string_view::npos &&
      bytes.find("127.0.0.1") == std::string_view::npos && bytes.find("::1") == std::string_view::npos)
    __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const rastro::detail::RequestRules open(scenes, "", true, 8420), closed(scenes, "s3cret", true, 8420);
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  check(open, bytes, false);
  check(closed, bytes, true);
  return 0;
}
