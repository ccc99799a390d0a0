// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/synthetic/scene.h"

namespace rastro::street {

// Materials of the street. `tone` is the mean grey of the bare material, 0..255.

/// A piece of road between two kerbs. The picture's y axis runs along the road; its first row is `along_m` metres down
/// the street, which the dashes in the middle follow.
Material road(double along_m);
Material crossing();
Material pavement();
Material kerb();
Material grass(double texels_per_metre);

/// The front of a house, with windows and doors from `floors` floors; others of its walls have few windows and less
/// detail.
Material house_front(float tone, int floors);
Material house_wall(float tone, int floors, double texels_per_metre);
Material roof(float tone);
Material chimney(float tone);
Material garden_wall(float tone);

Material bark();
Material foliage(float tone);
Material hedge();

Material pole(float tone);
/// A board with writing; round ones are painted on a square of their mean surroundings.
Material board();
Material street_lamp();

Material car_body(float tone);
Material car_cabin(float tone);
Material wheel();
Material shadow();

/// Walls of the sky, `height_m` high, the horizon `horizon_m` above their lower edge; and its top.
Material sky(double horizon_m);
Material sky_top();

}  // namespace rastro::street
