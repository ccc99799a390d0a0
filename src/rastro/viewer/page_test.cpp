// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/page.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>

namespace rastro {
namespace {

/// Of valid base64 alone.
std::string decoded(std::string_view text) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char letter : text) {
    if (letter == '=') break;
    bits = (bits << 6) | static_cast<std::uint32_t>(letters.find(letter));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>((bits >> count) & 255U);
  }
  return bytes;
}

std::string whole(const std::vector<NamedScene>& scenes) {
  std::string text;
  put_page_with_scenes(scenes, [&](std::string_view piece) { text += piece; });
  return text;
}

std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t from = text.find(begin);
  if (from == std::string::npos) return "none";
  const std::size_t start = from + begin.size();
  return text.substr(start, text.find(end, start) - start);
}

TEST(ViewerPage, IsAWholeDocumentThatLoadsNothing) {
  const std::string page(viewer_page());
  EXPECT_EQ(page.find("<!doctype html>") == 0 || page.find("<!DOCTYPE html>") == 0, true) << page.substr(0, 40);
  EXPECT_NE(page.find("</html>"), std::string::npos);
  EXPECT_NE(page.find("rastro-scene"), std::string::npos) << "it looks for the scenes by this name";
  for (const char* outside : {"<script src", "<link rel=\"stylesheet\"", "@import"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
}

TEST(ViewerPage, HoldsScenesBeforeItsScript) {
  std::string bytes;
  for (int k = 0; k < 1000; ++k) bytes += static_cast<char>(k * 7);
  const std::string page = whole({{"a \"<run>\" & more", bytes}, {"b", "xy"}, {"c", ""}});
  const std::string marker = "<script type=\"application/octet-stream;base64\" class=\"rastro-scene\" data-name=\"";
  EXPECT_EQ(decoded(between(page, marker + "a &quot;&lt;run&gt;&quot; &amp; more\">", "</script>")), bytes);
  EXPECT_EQ(between(page, marker + "b\">", "</script>"), "eHk=");
  EXPECT_EQ(between(page, marker + "c\">", "</script>"), "");
  EXPECT_LT(page.find(marker), std::string(viewer_page()).find("<script") + 1);
}

TEST(ViewerPage, WithoutScenesIsThePage) { EXPECT_EQ(whole({}), viewer_page()); }

TEST(ViewerPage, JoinsPiecesOfLargeScenes) {
  std::string bytes(7'000'001, 'r');
  bytes[3'145'728] = '!', bytes[6'999'999] = '?';
  EXPECT_EQ(decoded(between(whole({{"large", bytes}}), "data-name=\"large\">", "</script>")), bytes);
}

}  // namespace
}  // namespace rastro
