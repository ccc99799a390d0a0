// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/image_header.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace rastro {
namespace {

std::string size_in(std::string_view bytes) {
  const auto size = image_header_size({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
  return size ? std::to_string(size->width) + "x" + std::to_string(size->height) : "none";
}

std::string reason(std::string_view bytes) {
  return why_too_large({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
}

using namespace std::string_view_literals;

constexpr auto png = "\x89PNG\r\n\x1A\n\0\0\0\rIHDR\0\0\x4E\x20\0\0\x4E\x20\x08\0"sv;
constexpr auto jpeg = "\xFF\xD8\xFF\xE0\0\4ab\xFF\xC0\0\x0B\x08\1\xE0\2\x80\1\1\x11\0"sv;

TEST(ImageHeader, SaysTheSizeOfEveryKind) {
  EXPECT_EQ(size_in(png), "20000x20000");
  EXPECT_EQ(size_in(jpeg), "640x480");
  EXPECT_EQ(size_in("P5\n# a comment\n640 480\n255\n"), "640x480");
  EXPECT_EQ(size_in("P6 99999999999999999999999 4\n255\n"), "4294967295x4");
  EXPECT_EQ(size_in("BM\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\2\0\0\x20\xFE\xFF\xFF"sv), "640x480");
  EXPECT_EQ(size_in("II*\0\x08\0\0\0\2\0\0\1\3\0\1\0\0\0\x80\2\0\0\1\1\4\0\1\0\0\0\xE0\1\0\0"sv), "640x480");
  EXPECT_EQ(size_in("RIFF\0\0\0\0WEBPVP8X\0\0\0\0\0\0\0\0\x7F\2\0\xDF\1\0"sv), "640x480");
}

TEST(ImageHeader, SaysNothingOfOtherBytes) {
  for (const auto bytes :
       {""sv, "text, no image at all"sv, "P5\n640"sv, "\xFF\xD8\xFF\xE0\0\4ab"sv, "II*\0\xFF\xFF\xFF\xFF"sv})
    EXPECT_EQ(size_in(bytes), "none");
}

TEST(ImageHeader, RefusesWhatIsTooLarge) {
  EXPECT_EQ(reason(png), "claims 20000x20000 pixels, more than 134 million");
  EXPECT_EQ(reason(jpeg), "");
  EXPECT_EQ(reason("P5 11585 11585 255\n"), "");
  EXPECT_NE(reason("P5 18446744073709551615 18446744073709551615 255\n"), "");
}

}  // namespace
}  // namespace rastro
