// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/dataset/open.h"
#include "rastro/sensor/live_source.h"

namespace rastro {

/// The source with its depth put into the color image, where info().depth_registration tells how and depth is wanted;
/// else, and with options.raw_depth, as it is. UnusableSource for depth that has not the depth camera's size.
std::unique_ptr<Source> registered_depth(std::unique_ptr<Source> source, const OpenOptions& options);
std::unique_ptr<LiveSource> registered_depth(std::unique_ptr<LiveSource> source, const OpenOptions& options);

}  // namespace rastro
