// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/base/random.h"
#include "rastro/synthetic/paint/canvas.h"

namespace rastro::paint {

// Small details of the surfaces in an industrial hall. Positions and sizes in meters.

void bolt(Canvas& canvas, double x, double y, double radius, float tone);
void bolt_row(Canvas& canvas, double x0, double y0, double x1, double y1, double spacing, double radius, float tone);
/// A joint between two sheets: a dark groove with a lit edge beside it.
void seam(Canvas& canvas, double x0, double y0, double x1, double y1, double thickness);
/// A screwed-on cover.
void cover(Canvas& canvas, Random& random, const Canvas::Box& box, float tone);
void vent(Canvas& canvas, Random& random, const Canvas::Box& box, float tone);
/// A plate with a heading and lines of small print.
void label(Canvas& canvas, Random& random, const Canvas::Box& box);
void gauge(Canvas& canvas, Random& random, double x, double y, double radius);
void buttons(Canvas& canvas, Random& random, const Canvas::Box& box);
void hazard_band(Canvas& canvas, Random& random, const Canvas::Box& box);

void stains(Canvas& canvas, Random& random, int count, double smallest, double largest, float strength);
/// Chips, splashes and dirt from 2 mm to 3 cm, most of them small.
void specks(Canvas& canvas, Random& random, int count, float tone);
void drips(Canvas& canvas, Random& random, int count, float strength);
void scratches(Canvas& canvas, Random& random, int count, double longest);
void cracks(Canvas& canvas, Random& random, int count, double longest, float tone);
void cables(Canvas& canvas, Random& random, int count, float tone);
/// Chipped paint along the border of the image.
void worn_edges(Canvas& canvas, Random& random, float tone);

/// Divides a box into smaller and smaller panels, each with its own detail.
void panels(Canvas& canvas, Random& random, const Canvas::Box& box, float tone, double smallest);

/// Letters and digits such as "KX-204".
std::string code(Random& random, int letters, int digits);

}  // namespace rastro::paint
