// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/synthetic/scene.h"

namespace rastro::street {

// Materials of the street. `tone` is the mean intensity of the bare material, 0..255.

/// A piece of road between two kerbs. The image's y axis runs along the road; its first row is `along_m` meters down
/// the street, which sets the phase of the dashed center line.
Material road(double along_m);
Material crossing();
Material pavement();
Material kerb();
Material grass();
/// For faces that are never visible.
Material plain(float tone);

/// The front of a house with doors and windows; its other walls have fewer windows and less detail.
Material house_front(float tone, int floors);
Material house_wall(float tone, int floors);
Material roof(float tone);
Material garden_wall(float tone, double texels_per_meter = 60.0);

Material bark();
Material foliage(float tone);
Material hedge();

Material pole(float tone);
/// A board with writing.
Material board();
Material street_lamp();

Material car_body(float tone);
Material car_cabin(float tone);
Material wheel();
Material shadow();

/// Walls of the sky, the horizon `horizon_m` above their lower edge; and its top.
Material sky(double horizon_m);
Material sky_top();

}  // namespace rastro::street
