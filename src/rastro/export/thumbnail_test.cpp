// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/thumbnail.h"

#include <gmock/gmock.h>

#include "rastro/base/append_file.h"
#include "rastro/base/scratch_testing.h"

namespace rastro {
namespace {

using testing::StartsWith;

TEST(Thumbnail, Base64OfRfc4648) {
  EXPECT_EQ(as_base64(""), "");
  EXPECT_EQ(as_base64("f"), "Zg==");
  EXPECT_EQ(as_base64("fo"), "Zm8=");
  EXPECT_EQ(as_base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(as_base64("\xff\xfe"), "//4=");
}

TEST(Thumbnail, IsAJpegOfAboutTheSizeAsked) {
  Frame frame;
  frame.image = GrayImage(640, 480);
  const std::string large = thumbnail_of(frame, 640), small = thumbnail_of(frame, 64);
  EXPECT_THAT(small, StartsWith("data:image/jpeg;base64,/9j/"));
  EXPECT_LT(small.size(), large.size());
  frame.color.rgb = Image<std::uint8_t>(3 * 64, 48);
  EXPECT_THAT(thumbnail_of(frame, 320), StartsWith("data:image/jpeg"));
}

TEST(Thumbnail, WhatIsNoImageHasNone) {
  EXPECT_EQ(thumbnail_of(Frame(), 64), "");
  EXPECT_EQ(thumbnail_of(scratch_path("no.png").string(), 64), "");
  write_whole_file(scratch_path("text.png"), "no image");
  EXPECT_EQ(thumbnail_of(scratch_path("text.png").string(), 64), "");
}

}  // namespace
}  // namespace rastro
