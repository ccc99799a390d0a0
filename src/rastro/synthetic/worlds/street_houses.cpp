// SPDX-License-Identifier: Apache-2.0
// Textures of the street's houses.
#include "rastro/synthetic/paint/details.h"
#include "rastro/synthetic/worlds/street_materials.h"

namespace rastro::street {
namespace {

using namespace paint;

float some(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }
/// Fewer of them on canvases too coarse to show small details.
int many(const Canvas& canvas, double per_square_meter) {
  const double seen = std::min(1.0, canvas.texels_per_meter() / 20.0);
  return static_cast<int>(canvas.width() * canvas.height() * per_square_meter * seen * seen + 0.5);
}

void paint_stones(Canvas& canvas, Random& random, float tone, double length, double height, float spread) {
  int row = 0;
  for (double y = 0; y < canvas.height(); y += height, ++row)
    for (double x = (row & 1) != 0 ? -0.5 * length : 0.0; x < canvas.width(); x += length)
      canvas.rectangle(x, y, x + length - 0.02, y + height - 0.02, tone + some(random, -spread, spread));
}

void plaster(Canvas& canvas, Random& random, float tone) {
  canvas.fill(tone);
  canvas.add_noise(random, 4.0, 12.0F, 0.86F);
  for (int i = many(canvas, 0.06); i > 0; --i) {  // Missing or repaired plaster.
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    canvas.rectangle(x, y, x + random.uniform(0.2, 1.3), y + random.uniform(0.2, 0.9), tone + some(random, -34, 22),
                     0.6F);
  }
}

void glass(Canvas& canvas, Random& random, const Canvas::Box& box) {
  const double width = box.x1 - box.x0, height = box.y1 - box.y0;
  canvas.rectangle(box.x0, box.y0, box.x1, box.y1, some(random, 22, 62));
  // Reflected sky and houses, a curtain, a plant: no two windows are alike.
  for (int i = 0; i < 3; ++i) {
    const double x = box.x0 + width * random.uniform(0.0, 0.7), y = box.y0 + height * random.uniform(0.0, 0.7);
    canvas.rectangle(x, y, x + width * random.uniform(0.1, 0.3), y + height * random.uniform(0.1, 0.3),
                     some(random, 30, 165), 0.6F);
  }
  if (random.uniform() < 0.5) {
    const double share = random.uniform(0.15, 0.45);
    canvas.rectangle(box.x0, box.y0, box.x0 + share * width, box.y1, some(random, 110, 175), 0.7F);
    if (random.uniform() < 0.6)
      canvas.rectangle(box.x1 - share * width, box.y0, box.x1, box.y1, some(random, 110, 175), 0.7F);
  }
  if (random.uniform() < 0.3)
    canvas.rectangle(box.x0, box.y0, box.x1, box.y0 + height * random.uniform(0.1, 0.6), some(random, 95, 150));
  if (random.uniform() < 0.4) canvas.spot(box.x0 + 0.5 * width, box.y1 - 0.15, 0.3 * width, 0.12, -40.0F);
}

struct WindowStyle {
  double width, height, frame;
  float frame_tone;
  int panes;
  bool shutters;
  bool surround;
};

void window(Canvas& canvas, Random& random, double x, double y, const WindowStyle& style) {
  const Canvas::Box box{x, y, x + style.width, y + style.height};
  if (style.surround)
    canvas.outline(box.x0 - 0.06, box.y0 - 0.06, box.x1 + 0.06, box.y1 + 0.06, 0.12, style.frame_tone - 30.0F, 0.9F);
  glass(canvas, random, box);
  canvas.rectangle(box.x0, box.y0, box.x1, box.y0 + 0.07, 18.0F, 0.7F);  // Shade of the lintel.
  canvas.outline(box.x0, box.y0, box.x1, box.y1, style.frame, style.frame_tone);
  for (int pane = 1; pane < style.panes; ++pane) {
    const double at = box.x0 + style.width * pane / style.panes;
    canvas.line(at, box.y0, at, box.y1, style.frame, style.frame_tone);
  }
  if (style.panes > 1)
    canvas.line(box.x0, y + 0.3 * style.height, box.x1, y + 0.3 * style.height, 0.7 * style.frame, style.frame_tone);
  canvas.rectangle(box.x0 - 0.08, box.y1, box.x1 + 0.08, box.y1 + 0.09, 165.0F);
  canvas.rectangle(box.x0 - 0.08, box.y1 + 0.09, box.x1 + 0.08, box.y1 + 0.16, 30.0F, 0.6F);
  canvas.spot(box.x0, box.y1 + 0.5, 0.06, 0.35, -26.0F);  // Rain runs off the ends of the sill.
  canvas.spot(box.x1, box.y1 + 0.5, 0.06, 0.35, -22.0F);
  if (style.shutters)
    for (const double side : {box.x0 - 0.55 * style.width, box.x1 + 0.05}) {
      canvas.rectangle(side, box.y0, side + 0.5 * style.width, box.y1, 70.0F);
      for (double slat = box.y0 + 0.06; slat < box.y1 - 0.05; slat += 0.09)
        canvas.rectangle(side + 0.05, slat, side + 0.5 * style.width - 0.05, slat + 0.03, 38.0F);
    }
}

void door(Canvas& canvas, Random& random, double x, double ground) {
  const double width = random.uniform(1.0, 1.5), top = ground - 2.3;
  const float tone = some(random, 30, 120);
  canvas.outline(x - 0.05, top - 0.05, x + width + 0.05, ground, 0.16, 158.0F);
  canvas.rectangle(x, top, x + width, ground, tone);
  for (const double part : {0.12, 0.56})
    canvas.outline(x + part * width, top + 0.8, x + (part + 0.32) * width, ground - 0.3, 0.04, tone + 40.0F);
  glass(canvas, random, {x + 0.12 * width, top + 0.15, x + 0.88 * width, top + 0.65});
  canvas.rectangle(x - 0.3, ground - 0.16, x + width + 0.3, ground, 120.0F);
  label(canvas, random, {x + width + 0.15, ground - 1.6, x + width + 0.4, ground - 1.4});
}

void shop(Canvas& canvas, Random& random, double ground) {
  const double width = canvas.width();
  canvas.rectangle(0.3, ground - 3.2, width - 0.3, ground - 2.6, some(random, 30, 190));
  canvas.text(0.8, ground - 3.1, 0.4, code(random, 5, 2), 225.0F);
  for (double x = 0.5; x + 2.0 < width; x += 2.4) {
    glass(canvas, random, {x, ground - 2.5, x + 2.1, ground - 0.4});
    canvas.outline(x, ground - 2.5, x + 2.1, ground - 0.4, 0.07, 170.0F);
    if (random.uniform() < 0.6)
      label(canvas, random, {x + 0.3, ground - 1.7, x + 0.3 + random.uniform(0.4, 1.2), ground - 0.9});
  }
}

WindowStyle window_style(Random& random) {
  WindowStyle style{};
  style.width = random.uniform(0.9, 1.5);
  style.height = random.uniform(1.25, 1.7);
  style.frame = random.uniform(0.05, 0.10);
  style.frame_tone = random.uniform() < 0.75 ? some(random, 150, 190) : some(random, 30, 70);
  style.panes = 1 + static_cast<int>(random.below(3));
  style.shutters = random.uniform() < 0.35;
  style.surround = random.uniform() < 0.5;
  return style;
}

void window_rows(Canvas& canvas, Random& random, int floors, bool ground_floor, double share) {
  const WindowStyle style = window_style(random);
  const double width = canvas.width(), floor = canvas.height() / floors;
  const double pitch = style.width * (style.shutters ? 2.5 : random.uniform(1.5, 2.0));
  const int columns = std::max(1, static_cast<int>((width - 0.6) / pitch));
  for (int row = 0; row < (ground_floor ? floors : floors - 1); ++row)
    for (int column = 0; column < columns; ++column) {
      if (random.uniform() > share) continue;
      const double x = width * (column + 0.5) / columns - 0.5 * style.width;
      window(canvas, random, x, row * floor + 0.28 * floor, style);
    }
}

void weather(Canvas& canvas, Random& random, float tone) {
  const double width = canvas.width(), height = canvas.height();
  stains(canvas, random, many(canvas, 1.2), 0.06, 0.7, 36.0F);
  drips(canvas, random, many(canvas, 0.7), 34.0F);
  cracks(canvas, random, many(canvas, 0.07), 2.2, 0.5F * tone);
  specks(canvas, random, many(canvas, 6.0), tone);
  canvas.rectangle(0, height - 0.35, width, height, 0.5F * tone, 0.4F);  // Splashes from the pavement.
}

void paint_front(Canvas& canvas, Random& random, float tone, int floors) {
  const double width = canvas.width(), height = canvas.height(), floor = height / floors;
  if (random.uniform() < 0.4)
    paint_stones(canvas, random, tone, 0.34, 0.15, 24.0F);
  else
    plaster(canvas, random, tone);
  if (random.uniform() < 0.6) {
    paint::seam(canvas, 0, height - floor, width, height - floor, 0.05);
    canvas.rectangle(0, height - floor - 0.2, width, height - floor, tone > 110.0F ? tone - 35.0F : tone + 45.0F);
  }
  canvas.rectangle(0, height - 0.7, width, height, 0.6F * tone);
  weather(canvas, random, tone);
  const bool has_shop = random.uniform() < 0.3;
  window_rows(canvas, random, floors, !has_shop, 0.93);
  if (has_shop) shop(canvas, random, height);
  door(canvas, random, random.uniform(0.4, std::max(0.5, width - 2.2)), height);
  for (const double x : {0.06, width - 0.18})  // Down-pipes.
    if (random.uniform() < 0.7) {
      canvas.rectangle(x + 0.06, 0, x + 0.16, height, 30.0F, 0.5F);
      canvas.rectangle(x, 0, x + 0.11, height, tone > 110.0F ? 84.0F : 165.0F);
      for (double y = 0.8; y < height; y += 1.9) canvas.rectangle(x - 0.03, y, x + 0.14, y + 0.06, 40.0F);
    }
  canvas.rectangle(0, 0, width, 0.18, 60.0F, 0.8F);  // Shade of the eaves.
  if (random.uniform() < 0.5) {
    const double x = random.uniform(0.5, std::max(0.6, width - 2.0)), y = height - floor - random.uniform(0.7, 1.0);
    label(canvas, random, {x, y, x + random.uniform(0.8, 1.6), y + 0.6});
  }
}

void paint_wall(Canvas& canvas, Random& random, float tone, int floors) {
  if (random.uniform() < 0.5)
    paint_stones(canvas, random, tone, 0.4, 0.2, 22.0F);
  else
    plaster(canvas, random, tone);
  weather(canvas, random, tone);
  window_rows(canvas, random, floors, true, 0.45);
}

void paint_roof(Canvas& canvas, Random& random, float tone) {
  canvas.fill(0.5F * tone);
  const double tile = 0.30;
  for (double y = 0; y < canvas.height(); y += tile)
    for (double x = 0; x < canvas.width(); x += tile)
      canvas.rectangle(x, y, x + tile - 0.03, y + tile - 0.05, tone + some(random, -22, 22));
  canvas.add_noise(random, 3.0, 10.0F, 0.85F);
  stains(canvas, random, many(canvas, 0.3), 0.1, 0.8, 34.0F);
  for (int i = many(canvas, 0.03); i > 0; --i) {
    const double x = random.uniform(0.3, std::max(0.4, canvas.width() - 1.2));
    const double y = random.uniform(0.3, std::max(0.4, canvas.height() - 1.4));
    canvas.rectangle(x, y, x + 0.8, y + 1.0, 160.0F);
    glass(canvas, random, {x + 0.08, y + 0.08, x + 0.72, y + 0.92});
  }
}

void paint_garden_wall(Canvas& canvas, Random& random, float tone) {
  paint_stones(canvas, random, tone, 0.45, 0.22, 26.0F);
  canvas.add_noise(random, 1.0, 10.0F, 0.82F);
  stains(canvas, random, many(canvas, 1.0), 0.05, 0.5, 40.0F);
  drips(canvas, random, many(canvas, 1.0), 36.0F);
  specks(canvas, random, many(canvas, 8.0), tone);
}

}  // namespace

Material house_front(float tone, int floors) {
  return {[=](Canvas& canvas, Random& random) { paint_front(canvas, random, tone, floors); }, 55.0};
}
Material house_wall(float tone, int floors) {
  return {[=](Canvas& canvas, Random& random) { paint_wall(canvas, random, tone, floors); }, 24.0};
}
Material roof(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_roof(canvas, random, tone); }, 30.0};
}
Material garden_wall(float tone, double texels_per_meter) {
  return {[tone](Canvas& canvas, Random& random) { paint_garden_wall(canvas, random, tone); }, texels_per_meter};
}

}  // namespace rastro::street
