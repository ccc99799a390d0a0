// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/image.h"

namespace rastro {

/// Global histogram equalization: maps intensities so that each is used about equally often.
GrayImage equalized(GrayView image);

/// Mean and standard deviation of the intensities of every fourth pixel of every fourth row.
struct Brightness {
  double mean = 0.0;
  double deviation = 0.0;
};
Brightness brightness(GrayView image);

}  // namespace rastro
