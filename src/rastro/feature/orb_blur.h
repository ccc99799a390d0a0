// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include "rastro/image/padded_image.h"

namespace rastro {

/// Gaussian of sigma 2 pixels over 7x7, before binary tests (Rublee et al. 2011 smooth too): rows [begin, end) of
/// `target`, which has the source's size. The source's padding (at least 40) is filled.
void orb_blur(const PaddedImage& source, GrayImage& target, int begin, int end);

}  // namespace rastro
