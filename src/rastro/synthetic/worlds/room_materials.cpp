// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/room_materials.h"

#include <algorithm>
#include <cmath>

#include "rastro/synthetic/paint/details.h"

namespace rastro::room {
namespace {

using namespace paint;

constexpr Color white{235, 232, 224}, black{24, 24, 26}, paper{226, 221, 205}, ink{48, 48, 58};
constexpr Color bright[] = {{190, 60, 50},  {60, 110, 175}, {215, 175, 70}, {75, 140, 85},
                            {150, 85, 140}, {205, 120, 60}, {80, 150, 160}};

float some(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }
int many(const Canvas& canvas, double per_square_meter) {
  return static_cast<int>(canvas.width() * canvas.height() * per_square_meter + 0.5);
}
Color any(Random& random) { return bright[random.below(std::size(bright))]; }

/// Draws in a color, slightly lighter or darker.
float take(Canvas& canvas, const Color& color, float change = 0.0F) {
  canvas.set_ink(color.tint());
  return color.tone() + change;
}
void base(Canvas& canvas, const Color& color, Random& random, double coarsest_m, float amplitude) {
  canvas.fill(take(canvas, color));
  canvas.add_noise(random, coarsest_m, amplitude, 0.8F);
}

void lines_of_print(Canvas& canvas, Random& random, const Canvas::Box& box, double pitch, float value) {
  for (double y = box.y0; y + 0.4 * pitch < box.y1; y += pitch)
    canvas.rectangle(box.x0, y, box.x0 + random.uniform(0.5, 1.0) * (box.x1 - box.x0), y + 0.4 * pitch, value, 0.8F);
}

void paint_wall(Canvas& canvas, Random& random, const Color& color) {
  base(canvas, color, random, 2.0, 5.0F);
  if (canvas.height() > 2.0) canvas.rectangle(0, canvas.height() - 0.08, canvas.width(), canvas.height(), 205.0F);
  specks(canvas, random, many(canvas, 5.0), color.tone());
  stains(canvas, random, many(canvas, 0.5), 0.05, 0.3, 10.0F);
  scratches(canvas, random, many(canvas, 0.6), 0.25);
}

void paint_wallpaper(Canvas& canvas, Random& random, const Color& color, const Color& print) {
  base(canvas, color, random, 2.0, 4.0F);
  const float value = take(canvas, print);
  for (double y = 0.05; y < canvas.height() - 0.1; y += 0.19)
    for (double x = 0.05; x < canvas.width(); x += 0.19) {
      const double at_x = x + random.uniform(-0.04, 0.04), at_y = y + random.uniform(-0.04, 0.04);
      const int petals = 3 + static_cast<int>(random.below(4));
      const double reach = random.uniform(0.012, 0.03), phase = random.uniform(0.0, 6.0);
      for (int petal = 0; petal < petals; ++petal) {
        const double angle = phase + 6.2831853 * petal / petals;
        canvas.disc(at_x + reach * std::cos(angle), at_y + reach * std::sin(angle), 0.45 * reach, value, 0.7F);
      }
    }
  canvas.rectangle(0, canvas.height() - 0.08, canvas.width(), canvas.height(), take(canvas, white, -30.0F));
  stains(canvas, random, many(canvas, 0.4), 0.05, 0.3, 12.0F);
}

void paint_ceiling(Canvas& canvas, Random& random) {
  base(canvas, white, random, 2.0, 4.0F);
  specks(canvas, random, many(canvas, 4.0), 215.0F);
  cracks(canvas, random, 2, 1.2, 190.0F);
}

void paint_parquet(Canvas& canvas, Random& random, const Color& color) {
  const double width = 0.09, length = 0.7;
  canvas.fill(take(canvas, color));
  int row = 0;
  for (double y = 0; y < canvas.height(); y += width, ++row)
    for (double x = -length * 0.37 * (row % 3); x < canvas.width(); x += length) {
      const float tone = color.tone() + some(random, -17, 17);
      canvas.rectangle(x, y, x + length, y + width, tone);
      for (int grain = 0; grain < 5; ++grain) {
        const double at = y + random.uniform(0.01, width - 0.01), from = x + random.uniform(0.0, 0.5);
        canvas.line(from, at, from + random.uniform(0.1, 0.3), at + random.uniform(-0.006, 0.006), 0.004, tone - 20.0F,
                    0.5F);
      }
      canvas.line(x, y, x + length, y, 0.004, tone - 42.0F, 0.8F);
      canvas.line(x, y, x, y + width, 0.004, tone - 42.0F, 0.8F);
    }
  canvas.add_noise(random, 0.5, 6.0F, 0.8F);
  stains(canvas, random, many(canvas, 1.0), 0.03, 0.25, 16.0F);
}

void paint_rug(Canvas& canvas, Random& random, const Color& color, const Color& pattern) {
  base(canvas, color, random, 0.2, 9.0F);
  const double width = canvas.width(), height = canvas.height();
  const float value = take(canvas, pattern);
  for (const double inset : {0.06, 0.12, 0.30})
    canvas.outline(inset, inset, width - inset, height - inset, inset > 0.2 ? 0.025 : 0.018, value, 0.9F);
  for (int i = many(canvas, 14.0); i > 0; --i) {
    const double x = random.uniform(0.2, width - 0.2), y = random.uniform(0.2, height - 0.2),
                 r = random.uniform(0.02, 0.07);
    if (random.uniform() < 0.5)
      canvas.ring(x, y, r, 0.015, take(canvas, random.uniform() < 0.5 ? pattern : any(random)));
    else
      canvas.rectangle(x - r, y - 0.5 * r, x + r, y + 0.5 * r, take(canvas, pattern), 0.8F);
  }
}

void paint_wood(Canvas& canvas, Random& random, const Color& color) {
  const double width = canvas.width(), height = canvas.height();
  base(canvas, color, random, 0.4, 7.0F);
  const bool wide = width > height;
  for (int i = 4 + many(canvas, 26.0); i > 0; --i) {
    const double along = random.uniform(0.0, std::max(width, height)), length = random.uniform(0.08, 0.5),
                 across = random.uniform(0.0, std::min(width, height)), bend = random.uniform(-0.01, 0.01);
    const float tone = color.tone() - some(random, 12, 26);
    if (wide)
      canvas.line(along, across, along + length, across + bend, 0.004, tone, 0.6F);
    else
      canvas.line(across, along, across + bend, along + length, 0.004, tone, 0.6F);
  }
  scratches(canvas, random, many(canvas, 1.5), 0.1);
}

void paint_varnish(Canvas& canvas, Random& random, const Color& color) {
  base(canvas, color, random, 0.6, 5.0F);
  specks(canvas, random, many(canvas, 12.0), color.tone());
  scratches(canvas, random, many(canvas, 2.0), 0.12);
}

void paint_cloth(Canvas& canvas, Random& random, const Color& color) {
  base(canvas, color, random, 0.25, 15.0F);
  for (int i = many(canvas, 5.0); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    canvas.spot(x, y, random.uniform(0.02, 0.05), random.uniform(0.05, 0.25), -some(random, 10, 26));
  }
}

void paint_checks(Canvas& canvas, Random& random, const Color& color, const Color& other) {
  base(canvas, color, random, 0.3, 8.0F);
  // Not periodic: the widths of the stripes are random. None is near a border, so that an edge there is alone.
  const double hem = 0.09, widest = 0.07;
  for (double x = hem + random.uniform(0.0, 0.1); x + widest + hem < canvas.width(); x += random.uniform(0.13, 0.27))
    canvas.rectangle(x, 0, x + random.uniform(0.02, widest), canvas.height(), take(canvas, other), 0.55F);
  for (double y = hem + random.uniform(0.0, 0.1); y + widest + hem < canvas.height(); y += random.uniform(0.13, 0.27))
    canvas.rectangle(0, y, canvas.width(), y + random.uniform(0.02, widest), take(canvas, other), 0.55F);
  for (int i = many(canvas, 6.0); i > 0; --i)
    canvas.spot(random.uniform(0.0, canvas.width()), random.uniform(0.0, canvas.height()), random.uniform(0.03, 0.2),
                random.uniform(0.02, 0.06), -some(random, 10, 30));
}

/// A spine has a title; covers and pages are plainer.
void paint_book(Canvas& canvas, Random& random, const Color& color) {
  const double width = canvas.width(), height = canvas.height();
  base(canvas, color, random, 0.1, 5.0F);
  if (width > 0.08 && height > 0.1) return lines_of_print(canvas, random, {0.02, 0.03, width - 0.02, 0.1}, 0.02, 60.0F);
  const Color band = random.uniform() < 0.5 ? paper : any(random);
  const float value = take(canvas, band);
  for (int i = 1 + static_cast<int>(random.below(3)); i > 0; --i) {
    const double y = random.uniform(0.04, 0.9) * height;
    canvas.rectangle(0, y, width, y + random.uniform(0.004, 0.03), value);
  }
  const double left = 0.3 * width, right = 0.7 * width, top = random.uniform(0.12, 0.3) * height;
  for (double y = top; y < top + 0.45 * height; y += random.uniform(0.010, 0.018))
    canvas.rectangle(left, y, right - random.uniform(0.0, 0.15) * width, y + 0.007, value);
}

void paint_labeled_box(Canvas& canvas, Random& random, const Color& color) {
  const double width = canvas.width(), height = canvas.height();
  base(canvas, color, random, 0.3, 4.0F);
  // All of it well inside, so that only the box's own edges are near its border.
  const double x0 = 0.22 * width, x1 = 0.70 * width, y0 = 0.28 * height, y1 = 0.70 * height;
  canvas.rectangle(x0, y0, x1, y1, take(canvas, white));
  const float text = take(canvas, ink);
  canvas.text(x0 + 0.02, y0 + 0.015, 0.25 * (y1 - y0), code(random, 2, 2), text);
  lines_of_print(canvas, random, {x0 + 0.02, y0 + 0.5 * (y1 - y0), x1 - 0.02, y1 - 0.01}, 0.018, text);
  canvas.disc(0.80 * width, 0.45 * height, 0.03, take(canvas, bright[2]));
}

void paint_parcel(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  base(canvas, {172, 134, 92}, random, 0.3, 6.0F);
  canvas.rectangle(0.44 * width, 0, 0.56 * width, height, take(canvas, {196, 168, 122}), 0.8F);
  canvas.rectangle(0.08 * width, 0.55 * height, 0.38 * width, 0.88 * height, take(canvas, white));
  lines_of_print(canvas, random, {0.11 * width, 0.6 * height, 0.35 * width, 0.85 * height}, 0.02, take(canvas, ink));
  canvas.text(0.62 * width, 0.15 * height, 0.16 * height, code(random, 1, 2), take(canvas, ink));
  stains(canvas, random, many(canvas, 5.0), 0.02, 0.1, 20.0F);
}

void paint_art(Canvas& canvas, Random& random, const Color& color) {
  const double width = canvas.width(), height = canvas.height();
  base(canvas, color, random, 0.4, 12.0F);
  for (int i = 10; i > 0; --i) {
    const double x = random.uniform(0.1, 0.9) * width, y = random.uniform(0.1, 0.9) * height,
                 r = random.uniform(0.04, 0.16) * std::min(width, height);
    const float value = take(canvas, any(random), some(random, -25, 25));
    if (random.uniform() < 0.4)
      canvas.disc(x, y, r, value, 0.85F);
    else if (random.uniform() < 0.6)
      canvas.rectangle(x - r, y - 0.6 * r, x + r, y + 0.6 * r, value, 0.85F);
    else
      canvas.line(x, y, x + 3.0 * r * random.uniform(-1.0, 1.0), y + 3.0 * r * random.uniform(-1.0, 1.0), 0.02, value);
  }
  canvas.outline(0.02, 0.02, width - 0.02, height - 0.02, 0.04, take(canvas, {70, 52, 38}));
}

void paint_calendar(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height(), edge = 0.045;
  base(canvas, white, random, 0.3, 3.0F);
  const double middle = 0.5 * height;
  canvas.rectangle(edge, edge, width - edge, middle, take(canvas, {120, 160, 190}));
  canvas.rectangle(edge, 0.6 * middle, width - edge, middle, take(canvas, {86, 120, 70}));
  canvas.disc(0.68 * width, 0.38 * middle, 0.028, take(canvas, {240, 215, 120}));
  for (int tree = 0; tree < 5; ++tree)
    canvas.disc(random.uniform(0.25, 0.75) * width, random.uniform(0.55, 0.75) * middle, random.uniform(0.01, 0.025),
                take(canvas, {50, 84, 46}));
  canvas.text(edge, middle + 0.012, 0.022, "NOVEMBER", take(canvas, {180, 50, 45}));
  const double top = middle + 0.045, step_x = (width - 2 * edge) / 7.0, step_y = (height - edge - top) / 5.0;
  for (int day = 0; day < 30; ++day)
    canvas.text(edge + step_x * (day % 7), top + step_y * (day / 7), 0.016, std::to_string(day + 1),
                take(canvas, day % 7 == 6 ? Color{180, 50, 45} : ink));
}

void paint_screen(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  base(canvas, black, random, 0.2, 2.0F);
  canvas.rectangle(0.02, 0.02, width - 0.02, height - 0.02, take(canvas, {44, 62, 92}));
  for (int window = 0; window < 3; ++window) {
    const double x = random.uniform(0.05, 0.5) * width, y = random.uniform(0.08, 0.45) * height;
    const double x1 = std::min(x + 0.42 * width, width - 0.03), y1 = std::min(y + 0.42 * height, height - 0.03);
    canvas.rectangle(x, y, x1, y1, take(canvas, {205, 210, 216}));
    canvas.rectangle(x, y, x1, y + 0.02, take(canvas, any(random)));
    lines_of_print(canvas, random, {x + 0.01, y + 0.03, x1 - 0.01, y1 - 0.01}, 0.018, take(canvas, ink));
  }
}

void paint_keyboard(Canvas& canvas, Random& random) {
  base(canvas, black, random, 0.1, 3.0F);
  for (double y = 0.012; y + 0.016 < canvas.height(); y += 0.022)
    for (double x = 0.012; x + 0.016 < canvas.width(); x += 0.022)
      canvas.rectangle(x, y, x + 0.017, y + 0.017, take(canvas, {86, 86, 90}, some(random, -12, 22)));
}

void paint_door(Canvas& canvas, Random& random, const Color& color) {
  const double width = canvas.width(), height = canvas.height();
  base(canvas, color, random, 0.6, 5.0F);
  if (height < 1.5 || width < 0.5) return;
  for (const double y : {0.12, 0.58})
    for (const double inset : {0.0, 0.03})
      canvas.outline(0.16 * width + inset, y * height + inset, 0.84 * width - inset, (y + 0.34) * height - inset, 0.012,
                     color.tone() - (inset > 0.0 ? 20.0F : 45.0F));
  canvas.disc(0.08 * width, 0.52 * height, 0.03, take(canvas, {190, 170, 110}));
  scratches(canvas, random, 14, 0.2);
}

void paint_curtain(Canvas& canvas, Random& random, const Color& color) {
  base(canvas, color, random, 0.3, 6.0F);
  for (double x = 0.0; x < canvas.width(); x += random.uniform(0.06, 0.14))
    canvas.spot(x, 0.5 * canvas.height(), random.uniform(0.015, 0.035), canvas.height(), some(random, -45, 30));
  for (int i = many(canvas, 9.0); i > 0; --i)
    canvas.disc(random.uniform(0.0, canvas.width()), random.uniform(0.0, canvas.height()), random.uniform(0.01, 0.03),
                take(canvas, any(random)), 0.7F);
}

void paint_leaves(Canvas& canvas, Random& random) {
  base(canvas, {38, 66, 34}, random, 0.1, 8.0F);
  for (int i = many(canvas, 260.0); i > 0; --i)
    canvas.disc(random.uniform(0.0, canvas.width()), random.uniform(0.0, canvas.height()), random.uniform(0.01, 0.03),
                take(canvas, {74, 118, 58}, some(random, -50, 40)), 0.8F);
}

void paint_globe(Canvas& canvas, Random& random) {
  base(canvas, {70, 110, 165}, random, 0.2, 5.0F);
  for (int land = 0; land < 9; ++land) {
    const double x = random.uniform(0.05, 0.95) * canvas.width(), y = random.uniform(0.2, 0.8) * canvas.height();
    const float value = take(canvas, random.uniform() < 0.6 ? Color{120, 150, 80} : Color{190, 165, 105});
    for (int part = 0; part < 5; ++part)
      canvas.disc(x + random.uniform(-0.05, 0.05), y + random.uniform(-0.05, 0.05), random.uniform(0.015, 0.045),
                  value);
  }
}

template <typename Painter, typename... Arguments>
Material material(double texels_per_meter, Painter painter, Arguments... arguments) {
  return {[=](Canvas& canvas, Random& random) { painter(canvas, random, arguments...); }, texels_per_meter};
}

Material shining(Material shown) {
  shown.shines = true;
  return shown;
}
Material seen_in_infrared(Material shown, float infrared) {
  shown.infrared = infrared;
  return shown;
}

}  // namespace

Material wall_paint(Color color) { return material(120.0, paint_wall, color); }
Material wallpaper(Color color, Color print) { return material(150.0, paint_wallpaper, color, print); }
Material ceiling_paint() { return material(60.0, paint_ceiling); }
Material parquet(Color color) { return material(200.0, paint_parquet, color); }
Material rug(Color color, Color pattern) { return material(200.0, paint_rug, color, pattern); }
Material wood(Color color, double texels_per_meter) { return material(texels_per_meter, paint_wood, color); }
Material varnish(Color color, double texels_per_meter) { return material(texels_per_meter, paint_varnish, color); }
Material metal(Color color) { return seen_in_infrared(material(120.0, paint_varnish, color), 0.75F); }
Material cloth(Color color) { return material(150.0, paint_cloth, color); }
Material checks(Color color, Color other) { return material(200.0, paint_checks, color, other); }
Material book(Color color) { return material(450.0, paint_book, color); }
Material box_with_label(Color color) { return material(400.0, paint_labeled_box, color); }
Material parcel() { return material(250.0, paint_parcel); }
Material art(Color color) { return material(250.0, paint_art, color); }
Material calendar() { return material(500.0, paint_calendar); }
Material screen() { return seen_in_infrared(shining(material(400.0, paint_screen)), 0.45F); }
Material keyboard() { return seen_in_infrared(material(450.0, paint_keyboard), 0.6F); }
Material door(Color color) { return material(120.0, paint_door, color); }
Material curtain(Color color) { return material(150.0, paint_curtain, color); }
Material leaves() { return material(250.0, paint_leaves); }
Material globe() { return material(300.0, paint_globe); }
Material lamp(Color color) {
  return shining(material(40.0, [=](Canvas& canvas, Random&) { canvas.fill(take(canvas, color)); }));
}
Material glass_edge() { return seen_in_infrared(material(200.0, paint_varnish, Color{92, 138, 118}), 0.04F); }

}  // namespace rastro::room
