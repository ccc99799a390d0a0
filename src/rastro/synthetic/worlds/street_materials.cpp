// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/street_materials.h"

#include "rastro/synthetic/paint/details.h"
#include "rastro/synthetic/worlds/street_drive.h"

namespace rastro::street {
namespace {

using namespace paint;

float some(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }
/// Fewer of them on canvases too coarse to show small details.
int many(const Canvas& canvas, double per_square_meter) {
  const double seen = std::min(1.0, canvas.texels_per_meter() / 20.0);
  return static_cast<int>(canvas.width() * canvas.height() * per_square_meter * seen * seen + 0.5);
}

constexpr float asphalt_tone = 74.0F, mark_tone = 190.0F;

void asphalt(Canvas& canvas, Random& random) {
  canvas.fill(asphalt_tone + some(random, -5, 5));
  canvas.add_noise(random, 3.0, 9.0F, 0.86F);
  for (int i = many(canvas, 0.02); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    const double x1 = x + random.uniform(0.5, 2.0), y1 = y + random.uniform(0.5, 4.0);
    canvas.rectangle(x, y, x1, y1, asphalt_tone + some(random, -26, 18), 0.75F);
    canvas.outline(x, y, x1, y1, 0.03, 38.0F, 0.7F);
  }
  stains(canvas, random, many(canvas, 0.9), 0.05, 0.6, 26.0F);
  cracks(canvas, random, many(canvas, 0.16), 2.6, 34.0F);
  specks(canvas, random, many(canvas, 14.0), asphalt_tone);
}

void drain(Canvas& canvas, double x, double y) {
  canvas.rectangle(x, y, x + 0.45, y + 0.5, 50.0F);
  for (double bar = 0.06; bar < 0.45; bar += 0.07) canvas.rectangle(x + 0.04, y + bar, x + 0.41, y + bar + 0.03, 14.0F);
}

void manhole(Canvas& canvas, Random& random, double x, double y) {
  canvas.disc(x, y, 0.40, 44.0F);
  canvas.disc(x, y, 0.35, some(random, 58, 96));
  canvas.ring(x, y, 0.24, 0.03, 36.0F);
  for (double dy = -0.15; dy < 0.2; dy += 0.1)
    for (double dx = -0.15; dx < 0.2; dx += 0.1) canvas.disc(x + dx, y + dy, 0.022, 28.0F);
}

/// Wear of paint: grains of the road show through.
void mark(Canvas& canvas, Random& random, double x0, double y0, double x1, double y1) {
  canvas.rectangle(x0, y0, x1, y1, mark_tone + some(random, -14, 14), some(random, 0.72, 0.92));
  const double chips = 60.0 * (x1 - x0) * (y1 - y0);
  for (double i = 0; i < chips; i += 1.0)
    canvas.disc(random.uniform(x0, x1), random.uniform(y0, y1), random.uniform(0.006, 0.03), 96.0F, 0.8F);
}

void paint_road(Canvas& canvas, Random& random, double along_m) {
  asphalt(canvas, random);
  const double width = canvas.width(), height = canvas.height(), middle = 0.5 * width;
  for (const double track : {-0.5 * lane, 0.5 * lane})  // Polished by tires.
    for (const double side : {-0.8, 0.8})
      canvas.rectangle(middle + track + side - 0.22, 0, middle + track + side + 0.22, height, 62.0F, 0.28F);
  for (double y = -std::fmod(along_m, 9.0); y < height; y += 9.0)
    mark(canvas, random, middle - 0.07, y, middle + 0.07, y + 3.0);
  for (const double x : {middle - lane - 0.1, middle + lane - 0.02}) mark(canvas, random, x, 0, x + 0.12, height);
  canvas.line(middle + 0.25, 0, middle + 0.22, height, 0.025, 36.0F, 0.8F);
  for (int i = many(canvas, 0.012); i > 0; --i)
    manhole(canvas, random, random.uniform(1.0, width - 1.0), random.uniform(0.5, height));
  for (const double x : {0.0, width - 0.45})
    if (random.uniform() < 0.7) drain(canvas, x, random.uniform(0.0, std::max(0.1, height - 0.6)));
  for (int i = many(canvas, 0.03); i > 0; --i) {  // Litter on the road.
    const double x = random.uniform(0.0, width), y = random.uniform(0.0, height), size = random.uniform(0.04, 0.14);
    canvas.rectangle(x, y, x + size, y + size * random.uniform(0.4, 1.6), some(random, 20, 190), 0.8F);
  }
}

void paint_crossing(Canvas& canvas, Random& random) {
  asphalt(canvas, random);
  const double size = canvas.width();
  // Zebra crossings at all four sides, between the corners.
  for (double at = 3.5; at < size - 3.9; at += 1.0) {
    mark(canvas, random, at, 0.3, at + 0.5, 2.7);
    mark(canvas, random, at, size - 2.7, at + 0.5, size - 0.3);
    mark(canvas, random, 0.3, at, 2.7, at + 0.5);
    mark(canvas, random, size - 2.7, at, size - 0.3, at + 0.5);
  }
  for (int i = 0; i < 3; ++i) manhole(canvas, random, random.uniform(3.5, size - 3.5), random.uniform(3.5, size - 3.5));
}

void paint_pavement(Canvas& canvas, Random& random) {
  canvas.fill(70.0F);
  const double slab = random.uniform() < 0.5 ? 0.5 : 0.3;
  for (double y = 0; y < canvas.height(); y += slab)
    for (double x = 0; x < canvas.width(); x += slab)
      canvas.rectangle(x, y, x + slab - 0.02, y + slab - 0.02, 104.0F + some(random, -17, 17));
  canvas.add_noise(random, 2.0, 8.0F, 0.84F);
  for (int i = many(canvas, 0.03); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    vent(canvas, random, {x, y, x + random.uniform(0.3, 0.7), y + random.uniform(0.3, 0.6)}, 80.0F);
  }
  stains(canvas, random, many(canvas, 1.4), 0.05, 0.5, 34.0F);
  specks(canvas, random, many(canvas, 12.0), 104.0F);
  cracks(canvas, random, many(canvas, 0.1), 1.2, 46.0F);
}

void paint_kerb(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(122.0F);
  canvas.add_noise(random, 0.6, 12.0F, 0.8F);
  for (double x = random.uniform(0.0, 1.0); x < width; x += 1.0) canvas.rectangle(x, 0, x + 0.02, height, 48.0F);
  for (double y = random.uniform(0.0, 1.0); y < height; y += 1.0) canvas.rectangle(0, y, width, y + 0.02, 48.0F);
  stains(canvas, random, many(canvas, 3.0), 0.03, 0.3, 40.0F);
}

void paint_grass(Canvas& canvas, Random& random) {
  canvas.fill(66.0F);
  canvas.add_noise(random, 5.0, 10.0F, 0.9F);
  stains(canvas, random, many(canvas, 0.3), 0.2, 1.2, 26.0F);
}

void paint_bark(Canvas& canvas, Random& random) {
  canvas.fill(62.0F);
  canvas.add_noise(random, 0.4, 14.0F, 0.85F);
  for (int i = many(canvas, 30.0); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    canvas.line(x, y, x + random.uniform(-0.02, 0.02), y + random.uniform(0.1, 0.5), random.uniform(0.008, 0.03),
                random.uniform() < 0.7 ? 26.0F : 112.0F, 0.8F);
  }
}

void paint_leaves(Canvas& canvas, Random& random, float tone, double density, double largest) {
  canvas.fill(0.6F * tone);
  canvas.add_noise(random, 0.8, 0.35F * tone, 0.85F);
  for (int i = many(canvas, density); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    const double radius = largest * (0.2 + 0.8 * random.uniform() * random.uniform());
    canvas.disc(x, y, radius, tone * some(random, 0.15, 2.0), 0.75F);
  }
}

void paint_pole(Canvas& canvas, Random& random, float tone) {
  canvas.fill(tone);
  canvas.add_noise(random, 0.3, 8.0F, 0.8F);
  for (double y = random.uniform(0.4, 1.0); y < canvas.height(); y += random.uniform(0.5, 1.5))
    canvas.rectangle(0, y, canvas.width(), y + random.uniform(0.03, 0.35), some(random, 25, 215), 0.85F);
}

void paint_board(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  const bool dark = random.uniform() < 0.5;
  canvas.fill(dark ? 52.0F : 190.0F);
  const float ink = dark ? 215.0F : 28.0F;
  canvas.outline(0.06 * width, 0.06 * height, 0.94 * width, 0.94 * height, 0.05 * height, ink);
  canvas.text(0.15 * width, 0.2 * height, 0.24 * height, code(random, 2, 2), ink);
  canvas.text(0.15 * width, 0.56 * height, 0.16 * height, code(random, 4, 2), ink);
  canvas.add_noise(random, 0.2, 6.0F, 0.8F);
}

void paint_lamp(Canvas& canvas, Random& random) {
  canvas.fill(96.0F);
  canvas.add_noise(random, 0.2, 10.0F, 0.8F);
}

void paint_car_body(Canvas& canvas, Random& random, float tone) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(tone);
  // Reflection in the paint: the bright sky above, the dark road below.
  for (int band = 0; band < 5; ++band)
    canvas.rectangle(0, height * (0.08 + 0.16 * band), width, height * (0.16 + 0.17 * band),
                     tone + 34.0F - 17.0F * static_cast<float>(band), 0.6F);
  canvas.rectangle(0, 0.82 * height, width, height, 22.0F, 0.9F);
  if (width > 3.0) {
    for (const double x : {0.3, 0.52, 0.74}) canvas.line(x * width, 0.02, x * width, 0.8 * height, 0.02, 18.0F, 0.9F);
    for (const double x : {0.45, 0.67})
      canvas.rectangle(x * width, 0.25 * height, x * width + 0.18, 0.31 * height, 30.0F);
    for (const double x : {0.2, 0.81}) canvas.disc(x * width, 0.9 * height, 0.38, 14.0F);
    canvas.line(0, 0.4 * height, width, 0.4 * height, 0.03, tone > 110.0F ? tone - 50.0F : tone + 60.0F, 0.8F);
  } else if (width > 1.2) {
    for (const double x : {0.04, 0.76}) {
      canvas.rectangle(x * width, 0.16 * height, (x + 0.2) * width, 0.42 * height, 205.0F);
      canvas.outline(x * width, 0.16 * height, (x + 0.2) * width, 0.42 * height, 0.03, 30.0F);
    }
    canvas.rectangle(0.28 * width, 0.2 * height, 0.72 * width, 0.4 * height, 26.0F);
    canvas.rectangle(0.34 * width, 0.56 * height, 0.66 * width, 0.74 * height, 210.0F);
    canvas.text(0.37 * width, 0.59 * height, 0.11 * height, code(random, 2, 3), 20.0F);
  }
  canvas.add_noise(random, 0.4, 4.0F, 0.8F);
  stains(canvas, random, many(canvas, 3.0), 0.03, 0.25, 26.0F);
}

void paint_car_cabin(Canvas& canvas, Random& random, float tone) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(tone);
  if (height > 1.0) return canvas.add_noise(random, 1.0, 8.0F, 0.8F);  // The roof.
  canvas.rectangle(0.04 * width, 0.14 * height, 0.96 * width, 0.92 * height, 30.0F);
  for (int i = 0; i < 7; ++i) {
    const double x = random.uniform(0.05, 0.8) * width;
    canvas.rectangle(x, random.uniform(0.15, 0.5) * height, x + random.uniform(0.05, 0.3), 0.9 * height,
                     some(random, 15, 120), 0.7F);
  }
  if (width > 1.8)
    for (const double x : {0.36, 0.68}) canvas.rectangle(x * width, 0, x * width + 0.08, height, tone);
  canvas.add_noise(random, 0.5, 5.0F, 0.8F);
}

void paint_wheel(Canvas& canvas, Random&) {
  const double middle = 0.5 * canvas.width();
  canvas.fill(24.0F);
  if (canvas.height() < 0.5) return;
  canvas.disc(middle, middle, 0.62 * middle, 150.0F);
  canvas.ring(middle, middle, 0.4 * middle, 0.16 * middle, 60.0F);
  canvas.disc(middle, middle, 0.12 * middle, 40.0F);
}

void paint_sky(Canvas& canvas, Random& random, double horizon_m) {
  const double width = canvas.width(), height = canvas.height(), horizon = height - horizon_m;
  canvas.fill(212.0F);
  canvas.add_noise(random, 130.0, 15.0F, 0.6F);
  for (double y = 0; y < horizon; y += 4.0)
    canvas.rectangle(0, y, width, y + 4.0, 190.0F, static_cast<float>(0.35 * (1.0 - y / horizon)));
  canvas.rectangle(0, horizon - 4.0, width, height, 96.0F);
  for (double x = 0; x < width; x += random.uniform(4.0, 16.0))  // Far woods and houses.
    canvas.spot(x, horizon, random.uniform(4.0, 14.0), random.uniform(5.0, 16.0), -some(random, 40, 110));
  for (int i = static_cast<int>(width / 14.0); i > 0; --i) {
    const double x = random.uniform(0.0, width), top = horizon - random.uniform(4.0, 18.0);
    canvas.rectangle(x, top, x + random.uniform(5.0, 14.0), height, some(random, 80, 165));
    for (double y = top + 2.0; y < horizon; y += 3.0) canvas.rectangle(x + 1.0, y, x + 4.0, y + 1.4, 70.0F);
  }
}

void paint_sky_top(Canvas& canvas, Random& random) {
  canvas.fill(205.0F);
  canvas.add_noise(random, 130.0, 15.0F, 0.6F);
}

}  // namespace

Material road(double along_m) {
  return {[along_m](Canvas& canvas, Random& random) { paint_road(canvas, random, along_m); }, 90.0};
}
Material crossing() { return {paint_crossing, 90.0}; }
Material pavement() { return {paint_pavement, 60.0}; }
Material kerb() { return {paint_kerb, 60.0}; }
Material grass() { return {paint_grass, 2.0, true}; }
Material plain(float tone) {
  return {[tone](Canvas& canvas, Random&) { canvas.fill(tone); }, 2.0, true};
}
Material bark() { return {paint_bark, 90.0}; }
Material foliage(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_leaves(canvas, random, tone, 110.0, 0.11); }, 45.0};
}
Material hedge() {
  return {[](Canvas& canvas, Random& random) { paint_leaves(canvas, random, 62.0F, 160.0, 0.09); }, 55.0};
}
Material pole(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_pole(canvas, random, tone); }, 80.0};
}
Material board() { return {paint_board, 120.0}; }
Material street_lamp() { return {paint_lamp, 60.0}; }
Material car_body(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_car_body(canvas, random, tone); }, 90.0};
}
Material car_cabin(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_car_cabin(canvas, random, tone); }, 90.0};
}
Material wheel() { return {paint_wheel, 80.0}; }
Material shadow() {
  return {[](Canvas& canvas, Random&) { canvas.fill(24.0F); }, 10.0};
}
Material sky(double horizon_m) {
  return {[horizon_m](Canvas& canvas, Random& random) { paint_sky(canvas, random, horizon_m); }, 1.2, true};
}
Material sky_top() { return {paint_sky_top, 0.7, true}; }

}  // namespace rastro::street
