// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/synthetic/paint/tint.h"
#include "rastro/synthetic/scene.h"

namespace rastro::room {

// Materials of things at home.

Material wall_paint(Colour colour);
/// With a small print, as wallpaper has.
Material wallpaper(Colour colour, Colour print);
Material ceiling_paint();
Material parquet(Colour colour);
Material rug(Colour colour, Colour pattern);
Material wood(Colour colour, double texels_per_metre = 180.0);
/// Even, with few marks.
Material varnish(Colour colour, double texels_per_metre = 120.0);
Material metal(Colour colour);
Material cloth(Colour colour);
Material checks(Colour colour, Colour other);
Material book(Colour colour);
Material box_with_label(Colour colour);
Material parcel();
Material art(Colour colour);
/// A month: a picture above and the days below.
Material calendar();
Material screen();
Material keyboard();
Material door(Colour colour);
Material curtain(Colour colour);
Material leaves();
Material globe();
Material lamp(Colour colour);
/// The rim of a pane: seen, but no depth comes from it.
Material glass_edge();

}  // namespace rastro::room
