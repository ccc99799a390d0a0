// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/hall_materials.h"

#include "rastro/synthetic/paint/details.h"

namespace rastro::hall {
namespace {

using namespace paint;

float some(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }
double area(const Canvas& canvas) { return canvas.width() * canvas.height(); }
int many(const Canvas& canvas, double per_square_meter) {
  return static_cast<int>(area(canvas) * per_square_meter + 0.5);
}

void paint_floor(Canvas& canvas, Random& random) {
  canvas.fill(112.0F);
  canvas.add_noise(random, 4.0, 13.0F, 0.82F);
  const double slab = 2.9;
  for (double x = 0.4; x < canvas.width(); x += slab) seam(canvas, x, 0, x, canvas.height(), 0.014);
  for (double y = 0.7; y < canvas.height(); y += slab) seam(canvas, 0, y, canvas.width(), y, 0.014);
  for (double x = 1.1; x < canvas.width(); x += 7.3) canvas.rectangle(x, 0, x + 0.11, canvas.height(), 196.0F, 0.72F);
  for (double y = 4.9; y < canvas.height(); y += 5.6) canvas.rectangle(0, y, canvas.width(), y + 0.11, 196.0F, 0.72F);
  for (int i = many(canvas, 0.11); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width() - 1.2), y = random.uniform(0.0, canvas.height() - 0.8);
    if (random.uniform() < 0.5)
      canvas.text(x, y, random.uniform(0.15, 0.5), code(random, 1, 2), 200.0F, 0.75F);
    else
      hazard_band(canvas, random, {x, y, x + random.uniform(0.5, 1.2), y + random.uniform(0.15, 0.4)});
  }
  for (int i = many(canvas, 0.09); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    vent(canvas, random, {x, y, x + random.uniform(0.3, 0.6), y + random.uniform(0.3, 0.5)}, 80.0F);
  }
  for (int i = many(canvas, 0.5); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height()),
                 size = random.uniform(0.03, 0.16);
    canvas.rectangle(x, y, x + size, y + size * random.uniform(0.4, 1.6),
                     random.uniform() < 0.6 ? some(random, 30, 60) : some(random, 170, 225), 0.9F);
  }
  specks(canvas, random, many(canvas, 7.0), 112.0F);
  stains(canvas, random, many(canvas, 0.7), 0.05, 0.5, 34.0F);
  cracks(canvas, random, many(canvas, 0.25), 1.6, 42.0F);
  scratches(canvas, random, many(canvas, 1.5), 0.8);
}

void paint_bricks(Canvas& canvas, Random& random) {
  canvas.fill(150.0F);
  const double length = 0.30, height = 0.15, joint = 0.014;
  int row = 0;
  for (double y = 0; y < canvas.height(); y += height, ++row)
    for (double x = (row & 1) != 0 ? -0.5 * length : 0.0; x < canvas.width(); x += length)
      canvas.rectangle(x, y, x + length - joint, y + height - joint, 98.0F + some(random, -26, 26));
  canvas.rectangle(0, canvas.height() - 1.6, canvas.width(), canvas.height(), 70.0F, 0.55F);
  canvas.rectangle(0, canvas.height() - 1.66, canvas.width(), canvas.height() - 1.6, 205.0F, 0.8F);
  canvas.add_noise(random, 3.0, 11.0F, 0.8F);
  for (int i = many(canvas, 0.12); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height()),
                 w = random.uniform(0.3, 1.1);
    switch (random.below(3)) {
      case 0:
        label(canvas, random, {x, y, x + w, y + 0.7 * w});
        break;
      case 1:
        cover(canvas, random, {x, y, x + w, y + 1.2 * w}, some(random, 70, 180));
        break;
      default:
        canvas.rectangle(x, y, x + w, y + random.uniform(0.2, 0.9), some(random, 70, 160), 0.7F);
        break;
    }
  }
  specks(canvas, random, many(canvas, 6.0), 98.0F);
  stains(canvas, random, many(canvas, 0.35), 0.1, 0.9, 45.0F);
  drips(canvas, random, many(canvas, 0.5), 40.0F);
  cracks(canvas, random, many(canvas, 0.1), 2.0, 40.0F);
}

void paint_ceiling(Canvas& canvas, Random& random) {
  canvas.fill(92.0F);
  for (double x = 0; x < canvas.width(); x += 0.32) {
    canvas.rectangle(x, 0, x + 0.10, canvas.height(), 62.0F);
    canvas.rectangle(x + 0.10, 0, x + 0.14, canvas.height(), 128.0F);
  }
  for (double y = 1.1; y < canvas.height(); y += 2.7) {
    canvas.line(0, y, canvas.width(), y, 0.05, 45.0F);
    bolt_row(canvas, 0.2, y + 0.08, canvas.width(), y + 0.08, 0.64, 0.03, 110.0F);
  }
  canvas.add_noise(random, 3.0, 8.0F, 0.8F);
  stains(canvas, random, many(canvas, 0.4), 0.1, 0.7, 36.0F);
}

void paint_machine(Canvas& canvas, Random& random, float tone, double panel_m) {
  canvas.fill(tone + some(random, -12, 12));
  canvas.add_noise(random, 0.8, 8.0F, 0.72F);
  panels(canvas, random, {0, 0, canvas.width(), canvas.height()}, tone, panel_m);
  specks(canvas, random, many(canvas, 45.0), tone);
  if (random.uniform() < 0.5) cables(canvas, random, 1 + static_cast<int>(random.below(3)), 35.0F);
  stains(canvas, random, many(canvas, 3.0), 0.02, 0.2, 42.0F);
  drips(canvas, random, many(canvas, 3.0), 45.0F);
  scratches(canvas, random, many(canvas, 6.0), 0.25);
  worn_edges(canvas, random, tone > 110.0F ? 45.0F : 175.0F);
}

void paint_cabinet(Canvas& canvas, Random& random, float tone) {
  canvas.fill(tone);
  canvas.add_noise(random, 0.7, 6.0F, 0.7F);
  const double width = canvas.width(), height = canvas.height();
  const int doors = std::max(1, static_cast<int>(width / 0.55));
  for (int door = 0; door < doors; ++door) {
    const double x0 = width * door / doors, x1 = width * (door + 1) / doors, w = x1 - x0;
    canvas.outline(x0 + 0.02, 0.03, x1 - 0.02, height - 0.06, 0.008, 25.0F, 0.8F);
    vent(canvas, random, {x0 + 0.15 * w, 0.08 * height, x1 - 0.15 * w, 0.08 * height + std::min(0.3, 0.2 * height)},
         tone);
    canvas.rectangle(x1 - 0.09, 0.45 * height, x1 - 0.06, 0.45 * height + 0.16, 30.0F);
    label(canvas, random, {x0 + 0.2 * w, 0.42 * height, x0 + 0.2 * w + std::min(0.22, 0.4 * w), 0.42 * height + 0.14});
    canvas.text(x0 + 0.2 * w, 0.65 * height, 0.08, code(random, 1, 3), tone > 120.0F ? 25.0F : 225.0F);
    if (random.uniform() < 0.6)
      hazard_band(canvas, random, {x0 + 0.1 * w, 0.82 * height, x1 - 0.1 * w, 0.82 * height + 0.08});
  }
  specks(canvas, random, many(canvas, 30.0), tone);
  stains(canvas, random, many(canvas, 2.0), 0.03, 0.25, 35.0F);
  scratches(canvas, random, many(canvas, 6.0), 0.2);
  worn_edges(canvas, random, tone > 110.0F ? 40.0F : 170.0F);
}

void paint_tank(Canvas& canvas, Random& random, float tone) {
  canvas.fill(tone);
  canvas.add_noise(random, 1.0, 9.0F, 0.75F);
  for (double y = 0.25; y < canvas.height(); y += 0.85) {
    seam(canvas, 0, y, canvas.width(), y, 0.012);
    bolt_row(canvas, 0.04, y - 0.05, canvas.width(), y - 0.05, 0.13, 0.014, tone);
  }
  for (double x = 0.6; x < canvas.width(); x += 1.45) seam(canvas, x, 0, x, canvas.height(), 0.01);
  for (int i = many(canvas, 0.7); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height()),
                 w = random.uniform(0.15, 0.5);
    if (random.uniform() < 0.4)
      gauge(canvas, random, x, y, 0.12);
    else if (random.uniform() < 0.5)
      label(canvas, random, {x, y, x + w, y + 0.7 * w});
    else
      canvas.text(x, y, 0.4 * w, code(random, 1, 2), 30.0F);
  }
  specks(canvas, random, many(canvas, 20.0), tone);
  stains(canvas, random, many(canvas, 1.5), 0.05, 0.4, 40.0F);
  drips(canvas, random, many(canvas, 3.0), 55.0F);
}

void paint_pipe(Canvas& canvas, Random& random, float tone) {
  canvas.fill(tone);
  canvas.add_noise(random, 0.6, 10.0F, 0.75F);
  for (double y = random.uniform(0.2, 0.6); y < canvas.height(); y += random.uniform(0.5, 1.6)) {
    canvas.rectangle(0, y, canvas.width(), y + 0.07, tone > 120.0F ? 55.0F : 165.0F);
    bolt_row(canvas, 0.02, y + 0.035, canvas.width(), y + 0.035, 0.06, 0.012, 120.0F);
    if (random.uniform() < 0.4) canvas.rectangle(0, y + 0.2, canvas.width(), y + 0.3, some(random, 30, 230));
  }
  specks(canvas, random, many(canvas, 25.0), tone);
  stains(canvas, random, many(canvas, 5.0), 0.02, 0.12, 45.0F);
}

void paint_beam(Canvas& canvas, Random& random, float tone) {
  canvas.fill(tone);
  canvas.add_noise(random, 0.8, 10.0F, 0.75F);
  const double width = canvas.width(), height = canvas.height();
  const bool wide = width > height;
  const double length = wide ? width : height, edge = std::min(0.03, 0.2 * std::min(width, height));
  if (wide) {
    bolt_row(canvas, 0.1, edge, width - 0.1, edge, 0.19, 0.014, tone);
    bolt_row(canvas, 0.1, height - edge, width - 0.1, height - edge, 0.19, 0.014, tone);
  } else {
    bolt_row(canvas, edge, 0.1, edge, height - 0.1, 0.19, 0.014, tone);
    bolt_row(canvas, width - edge, 0.1, width - edge, height - 0.1, 0.19, 0.014, tone);
  }
  for (double at = random.uniform(0.3, 1.0); at + 0.5 < length; at += random.uniform(0.8, 2.0)) {
    const double across = wide ? height : width, letter = std::min(0.16, 0.5 * across);
    const double x = wide ? at : 0.2 * across, y = wide ? 0.25 * across : at;
    switch (random.below(3)) {
      case 0:
        canvas.text(x, y, letter, code(random, 1, 2), 220.0F, 0.9F);
        break;
      case 1:
        cover(canvas, random, {x, y, x + 0.5 * across + 0.08, y + 0.5 * across}, tone + some(random, -50, 60));
        break;
      default:
        if (wide)
          hazard_band(canvas, random, {at, 0, at + random.uniform(0.3, 0.6), height});
        else
          hazard_band(canvas, random, {0, at, width, at + random.uniform(0.3, 0.6)});
    }
  }
  specks(canvas, random, many(canvas, 30.0), tone);
  stains(canvas, random, many(canvas, 3.0), 0.03, 0.2, 45.0F);
  scratches(canvas, random, many(canvas, 5.0), 0.25);
}

void paint_pillar(Canvas& canvas, Random& random) {
  canvas.fill(136.0F);
  canvas.add_noise(random, 1.0, 12.0F, 0.8F);
  const double width = canvas.width(), height = canvas.height();
  for (double y = 0.5; y < height; y += 0.92) seam(canvas, 0, y, width, y, 0.01);
  if (height > 1.0) {
    hazard_band(canvas, random, {0, height - 1.15, width, height - 0.75});
    canvas.text(0.18 * width, height - 2.05, 0.2, code(random, 1, 1), 25.0F);
    label(canvas, random, {0.2 * width, height - 1.6, 0.75 * width, height - 1.33});
    label(canvas, random, {0.3 * width, height - 2.75, 0.85 * width, height - 2.4});
    cables(canvas, random, 1, 40.0F);
  }
  for (int i = many(canvas, 12.0); i > 0; --i)
    canvas.disc(random.uniform(0.0, width), random.uniform(0.0, height), random.uniform(0.004, 0.016),
                some(random, 40, 80));
  specks(canvas, random, many(canvas, 90.0), 136.0F);
  stains(canvas, random, many(canvas, 6.0), 0.03, 0.2, 45.0F);
  cracks(canvas, random, many(canvas, 1.5), 0.6, 50.0F);
  worn_edges(canvas, random, 200.0F);
}

void paint_crate(Canvas& canvas, Random& random) {
  const double plank = 0.11, width = canvas.width(), height = canvas.height();
  canvas.fill(30.0F);
  for (double y = 0; y < height; y += plank)
    canvas.rectangle(0, y, width, y + plank - 0.008, 142.0F + some(random, -28, 28));
  for (const double x : {0.0, width - 0.09}) canvas.rectangle(x, 0, x + 0.09, height, 168.0F);
  canvas.line(0.05, 0.05, width - 0.05, height - 0.05, 0.085, 158.0F);
  canvas.add_noise(random, 0.3, 8.0F, 0.8F);
  for (const double x : {0.045, width - 0.045}) bolt_row(canvas, x, 0.05, x, height - 0.05, plank, 0.008, 60.0F);
  specks(canvas, random, many(canvas, 45.0), 142.0F);
  canvas.text(0.3 * width, 0.3 * height, 0.16 * height, code(random, 2, 3), 30.0F, 0.85F);
  label(canvas, random, {0.55 * width, 0.62 * height, 0.55 * width + 0.2, 0.62 * height + 0.13});
  stains(canvas, random, many(canvas, 4.0), 0.02, 0.12, 40.0F);
}

void paint_cardboard(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(some(random, 110, 190));
  canvas.add_noise(random, 0.3, 7.0F, 0.75F);
  canvas.rectangle(0.45 * width, 0, 0.55 * width, height, 205.0F, 0.7F);
  canvas.text(0.08 * width, 0.12 * height, 0.18 * height, code(random, 2, 2), 35.0F, 0.9F);
  label(canvas, random, {0.58 * width, 0.45 * height, 0.92 * width, 0.9 * height});
  canvas.line(0.12 * width, 0.85 * height, 0.12 * width, 0.6 * height, 0.02, 30.0F);
  canvas.line(0.05 * width, 0.68 * height, 0.12 * width, 0.6 * height, 0.02, 30.0F);
  canvas.line(0.19 * width, 0.68 * height, 0.12 * width, 0.6 * height, 0.02, 30.0F);
  stains(canvas, random, many(canvas, 4.0), 0.02, 0.1, 30.0F);
  worn_edges(canvas, random, 80.0F);
}

void paint_lid(Canvas& canvas, Random& random, float tone) {
  const double radius = 0.5 * canvas.width();
  canvas.fill(tone);
  canvas.add_noise(random, 0.3, 9.0F, 0.75F);
  canvas.ring(radius, radius, 0.93 * radius, 0.05 * radius, tone - 50.0F);
  canvas.ring(radius, radius, 0.86 * radius, 0.03 * radius, tone + 45.0F, 0.7F);
  bolt(canvas, radius * 1.5, radius, 0.13 * radius, tone - 20.0F);
  bolt(canvas, radius * 0.6, radius * 1.3, 0.07 * radius, tone - 10.0F);
  canvas.text(0.6 * radius, 0.7 * radius, 0.22 * radius, code(random, 1, 2), tone > 120.0F ? 40.0F : 215.0F, 0.8F);
  specks(canvas, random, many(canvas, 60.0), tone);
  stains(canvas, random, many(canvas, 8.0), 0.02, 0.12, 40.0F);
}

void paint_drum(Canvas& canvas, Random& random, float tone) {
  canvas.fill(tone);
  canvas.add_noise(random, 0.4, 9.0F, 0.75F);
  for (int ring = 1; ring <= 2; ++ring)
    seam(canvas, 0, canvas.height() * ring / 3.0, canvas.width(), canvas.height() * ring / 3.0, 0.022);
  canvas.rectangle(0, 0.40 * canvas.height(), canvas.width(), 0.60 * canvas.height(), tone > 120.0F ? 60.0F : 195.0F,
                   0.9F);
  for (double x = 0.1; x + 0.3 < canvas.width(); x += random.uniform(0.4, 0.6)) {
    canvas.text(x, 0.44 * canvas.height(), 0.1, code(random, 1, 2), tone > 120.0F ? 225.0F : 30.0F);
    label(canvas, random, {x, 0.7 * canvas.height(), x + 0.2, 0.88 * canvas.height()});
  }
  specks(canvas, random, many(canvas, 60.0), tone);
  stains(canvas, random, many(canvas, 6.0), 0.02, 0.12, 45.0F);
  drips(canvas, random, many(canvas, 5.0), 45.0F);
  scratches(canvas, random, many(canvas, 10.0), 0.12);
}

void paint_window(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(40.0F);
  const int columns = std::max(2, static_cast<int>(width / 0.45)), rows = std::max(2, static_cast<int>(height / 0.5));
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const double x = width * column / columns, y = height * row / rows;
      const float tone = random.uniform() < 0.14 ? some(random, 70, 130) : some(random, 185, 240);
      canvas.rectangle(x + 0.03, y + 0.03, x + width / columns - 0.03, y + height / rows - 0.03, tone);
    }
  canvas.add_noise(random, 0.8, 6.0F, 0.7F);
  stains(canvas, random, many(canvas, 3.0), 0.05, 0.25, 40.0F);
}

void paint_gate(Canvas& canvas, Random& random) {
  canvas.fill(124.0F);
  for (double y = 0; y < canvas.height(); y += 0.24) seam(canvas, 0, y, canvas.width(), y, 0.02);
  canvas.add_noise(random, 1.0, 9.0F, 0.78F);
  canvas.text(0.15 * canvas.width(), 0.2 * canvas.height(), 0.26 * canvas.height(), code(random, 0, 2), 222.0F, 0.9F);
  hazard_band(canvas, random, {0, canvas.height() - 0.3, canvas.width(), canvas.height()});
  vent(canvas, random, {0.6 * canvas.width(), 0.55 * canvas.height(), 0.85 * canvas.width(), 0.8 * canvas.height()},
       120.0F);
  stains(canvas, random, many(canvas, 1.0), 0.1, 0.5, 45.0F);
}

void paint_sign(Canvas& canvas, Random& random, bool hazard) {
  label(canvas, random, {0, 0, canvas.width(), canvas.height()});
  if (hazard) hazard_band(canvas, random, {0, 0.82 * canvas.height(), canvas.width(), canvas.height()});
}

}  // namespace

Material concrete_floor() { return {paint_floor, 120.0}; }
Material brick_wall() { return {paint_bricks, 70.0}; }
Material ceiling_sheet() { return {paint_ceiling, 50.0}; }
Material machine(float tone, double texels_per_meter, double panel_m) {
  const auto paint = [=](Canvas& canvas, Random& random) { paint_machine(canvas, random, tone, panel_m); };
  return {paint, texels_per_meter};
}
Material cabinet(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_cabinet(canvas, random, tone); }, 170.0};
}
Material tank(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_tank(canvas, random, tone); }, 140.0};
}
Material pipe(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_pipe(canvas, random, tone); }, 90.0};
}
Material steel_beam(float tone, double texels_per_meter) {
  return {[tone](Canvas& canvas, Random& random) { paint_beam(canvas, random, tone); }, texels_per_meter};
}
Material concrete_pillar() { return {paint_pillar, 320.0}; }
Material wooden_crate() { return {paint_crate, 200.0}; }
Material cardboard() { return {paint_cardboard, 150.0}; }
Material drum(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_drum(canvas, random, tone); }, 200.0};
}
Material lid(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_lid(canvas, random, tone); }, 200.0};
}
Material window() { return {paint_window, 50.0, true}; }
Material gate() { return {paint_gate, 80.0}; }
Material sign(bool hazard) {
  return {[hazard](Canvas& canvas, Random& random) { paint_sign(canvas, random, hazard); }, 120.0};
}
Material lamp() {
  return {[](Canvas& canvas, Random&) { canvas.fill(250.0F); }, 10.0, true};
}

}  // namespace rastro::hall
