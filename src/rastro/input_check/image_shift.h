// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>

#include "rastro/sensor/frame.h"

namespace rastro {

/// An image of about 80 x 60 cells, smoothed. NaN where a cell has no value.
using Thumbnail = Image<float>;
Thumbnail thumbnail_of(const GrayImage& image);
/// Of the inverse depth, 1/m.
Thumbnail thumbnail_of(const DepthImage& depth);

/// The common translation between two thumbnails, cells: one step of Lucas and Kanade (1981) over all cells. For
/// motions of about a cell, and in proportion beyond. Zero where too little is seen.
Eigen::Vector2d shift_between(const Thumbnail& first, const Thumbnail& second);

}  // namespace rastro
