// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/page.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr std::size_t bytes_per_group = 3, letters_per_group = 4;

/// RFC 4648, with padding.
std::string base64(std::string_view bytes) {
  constexpr const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / bytes_per_group * letters_per_group);
  for (std::size_t k = 0; k < bytes.size(); k += bytes_per_group) {
    const std::size_t count = std::min(bytes_per_group, bytes.size() - k);
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < bytes_per_group; ++i)
      group = (group << 8) | (i < count ? static_cast<std::uint8_t>(bytes[k + i]) : 0U);
    for (std::size_t i = 0; i < letters_per_group; ++i)
      text += i <= count ? letters[(group >> (18 - 6 * i)) & 63U] : '=';
  }
  return text;
}

/// For an attribute in double quotes.
std::string escaped(std::string_view text) {
  std::string safe;
  for (const char letter : text) {
    switch (letter) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += letter;
    }
  }
  return safe;
}

}  // namespace

void put_page_with_scenes(std::span<const NamedScene> scenes, const std::function<void(std::string_view)>& put) {
  const std::string_view page = viewer_page();
  // The page's own script looks for them, so they stand before it.
  const std::size_t script = page.find("<script");
  RASTRO_CHECK(script != std::string_view::npos, "the page has a script");
  // Whole groups, so that pieces of base64 can stand one after the other.
  constexpr std::size_t piece = bytes_per_group * (1U << 20);
  put(page.substr(0, script));
  for (const NamedScene& scene : scenes) {
    put("<script type=\"application/octet-stream;base64\" class=\"rastro-scene\" data-name=\"" + escaped(scene.name) +
        "\">");
    const std::string_view bytes = scene.bytes;
    for (std::size_t k = 0; k < bytes.size(); k += piece) put(base64(bytes.substr(k, piece)));
    put("</script>\n");
  }
  put(page.substr(script));
}

}  // namespace rastro
