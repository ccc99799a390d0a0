// SPDX-License-Identifier: Apache-2.0
// TUM's lists of images, associations and depth factors: whatever the text, they are read or refused with
// rastro::Error.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/dataset/tum_rgbd/depth_factor.h"
#include "rastro/dataset/tum_rgbd/tum_rgbd.h"

namespace {

template <typename Read>
void refuse_or_read(Read read) {
  try {
    read();
  } catch (const rastro::Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  refuse_or_read([&] {
    const auto list = rastro::parse_tum_image_list(text, "input");
    if (list.images.empty()) __builtin_trap();
    rastro::associate(list.images, list.images, 20'000'000);
  });
  refuse_or_read([&] {
    const auto pairs = rastro::parse_tum_associations(text, "input");
    if (pairs.color.images.size() != pairs.depth.images.size()) __builtin_trap();
  });
  refuse_or_read([&] {
    const auto factor = rastro::parse_depth_factor(text, "input");
    if (factor && !(*factor > 0.0)) __builtin_trap();
  });
  return 0;
}
