// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/track_images.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/export/drawing.h"

namespace rastro {

TrackImages::TrackImages(std::filesystem::path folder) : folder_(std::move(folder)) {
  std::error_code code;
  std::filesystem::create_directories(folder_, code);
  if (code) throw Error("the folder cannot be made (" + code.message() + ")", folder_.string(), "choose another --out");
}

void TrackImages::write(const TrackFrame& frame, GrayView image) {
  drawing::save((folder_ / fmt::format("{:06}.png", frame.index)).string(), drawing::overlay(frame, image));
}

}  // namespace rastro
