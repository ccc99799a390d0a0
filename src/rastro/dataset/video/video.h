// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/dataset/open.h"

namespace rastro {

/// A video file through OpenCV. Stamps are its presentation times, from the first frame on, or frame number over
/// --rate. Error where it cannot be opened, and always in a build without video.
std::unique_ptr<Source> open_video(const std::string& path, const OpenOptions& options);

}  // namespace rastro
