// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/synthetic/paint/tint.h"
#include "rastro/synthetic/scene.h"

namespace rastro::room {

// Materials of objects at home.

Material wall_paint(Color color);
/// With a small print, like wallpaper.
Material wallpaper(Color color, Color print);
Material ceiling_paint();
Material parquet(Color color);
Material rug(Color color, Color pattern);
Material wood(Color color, double texels_per_meter = 180.0);
/// Even, with few marks.
Material varnish(Color color, double texels_per_meter = 120.0);
Material metal(Color color);
Material cloth(Color color);
Material checks(Color color, Color other);
Material book(Color color);
Material box_with_label(Color color);
Material parcel();
Material art(Color color);
/// A month: an image above and the days below.
Material calendar();
Material screen();
Material keyboard();
Material door(Color color);
Material curtain(Color color);
Material leaves();
Material globe();
Material lamp(Color color);
/// The rim of a pane: visible, but without depth.
Material glass_edge();

}  // namespace rastro::room
