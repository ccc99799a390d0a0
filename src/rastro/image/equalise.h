// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/image.h"

namespace rastro {

/// Global histogram equalisation: grey levels are spread so that each is used about equally often.
GreyImage equalised(GreyView image);

/// Mean and standard deviation of the grey levels of every fourth pixel of every fourth row.
struct Brightness {
  double mean = 0.0;
  double deviation = 0.0;
};
Brightness brightness(GreyView image);

}  // namespace rastro
