// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/campus_materials.h"

#include "rastro/synthetic/paint/details.h"

namespace rastro::campus {
namespace {

using namespace paint;

float between(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }
int count_on(const Canvas& canvas, double per_square_meter) {
  return static_cast<int>(canvas.width() * canvas.height() * per_square_meter + 0.5);
}

void paint_corridor_wall(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(158.0F);
  canvas.add_noise(random, 2.0, 6.0F, 0.86F);
  specks(canvas, random, count_on(canvas, 7.0), 140.0F);
  stains(canvas, random, count_on(canvas, 0.5), 0.05, 0.4, 18.0F);
  cracks(canvas, random, count_on(canvas, 0.06), 0.8, 105.0F);
  if (height < 2.0) return;
  canvas.rectangle(0, height - 1.1, width, height, 112.0F, 0.75F);
  canvas.rectangle(0, height - 1.16, width, height - 1.08, 62.0F);  // The handrail and its shade.
  canvas.rectangle(0, height - 1.08, width, height - 1.05, 40.0F, 0.5F);
  canvas.rectangle(0, height - 0.1, width, height, 70.0F);
  scratches(canvas, random, count_on(canvas, 1.2), 0.7);
  for (double x = random.uniform(0.3, 1.0); x < width; x += random.uniform(1.5, 3.0)) {  // Sockets.
    canvas.outline(x, height - 0.32, x + 0.08, height - 0.24, 0.012, 200.0F);
    canvas.disc(x + 0.04, height - 0.28, 0.025, 60.0F);
  }
}

void paint_floor(Canvas& canvas, Random& random) {
  const double tile = 0.5;
  for (double y = 0; y < canvas.height(); y += tile)
    for (double x = 0; x < canvas.width(); x += tile)
      canvas.rectangle(x, y, x + tile - 0.008, y + tile - 0.008, 96.0F + between(random, -10, 10));
  canvas.add_noise(random, 1.5, 7.0F, 0.88F);
  canvas.rectangle(0, 0.32 * canvas.height(), canvas.width(), 0.68 * canvas.height(), 112.0F, 0.22F);
  specks(canvas, random, count_on(canvas, 12.0), 92.0F);
  stains(canvas, random, count_on(canvas, 0.8), 0.05, 0.4, 24.0F);
  scratches(canvas, random, count_on(canvas, 0.7), 0.5);
}

void paint_ceiling(Canvas& canvas, Random& random) {
  const double panel = 0.6, middle = 0.5 * canvas.height();
  canvas.fill(118.0F);
  for (double x = 0; x < canvas.width(); x += panel)
    for (double y = 0; y < canvas.height(); y += panel)
      canvas.rectangle(x + 0.01, y + 0.01, x + panel - 0.01, y + panel - 0.01, between(random, 150, 162));
  specks(canvas, random, count_on(canvas, 16.0), 125.0F);
  for (const double share : {0.25, 0.75}) {
    const double x = share * canvas.width();
    canvas.rectangle(x - 0.62, middle - 0.17, x + 0.62, middle + 0.17, 90.0F);
    canvas.rectangle(x - 0.58, middle - 0.13, x + 0.58, middle + 0.13, 248.0F);
    for (double bar = -0.5; bar < 0.55; bar += 0.1)
      canvas.rectangle(x + bar, middle - 0.13, x + bar + 0.012, middle + 0.13, 190.0F);
  }
}

void paint_door(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(92.0F);
  canvas.add_noise(random, 0.5, 7.0F, 0.85F);
  for (int i = count_on(canvas, 16.0); i > 0; --i) {
    const double x = random.uniform(0.0, width), y = random.uniform(0.0, height);
    canvas.line(x, y, x + random.uniform(-0.01, 0.01), y + random.uniform(0.1, 0.5), 0.005, 72.0F, 0.7F);
  }
  if (width < 0.5 || height < 1.5) return;
  canvas.outline(0, 0, width, height, 0.14, 176.0F);  // The frame.
  canvas.outline(0.07, 0.07, width - 0.07, height, 0.012, 35.0F);
  canvas.rectangle(0.62 * width, 0.35, 0.76 * width, 1.05, 45.0F);
  canvas.outline(0.62 * width, 0.35, 0.76 * width, 1.05, 0.02, 150.0F);
  canvas.rectangle(0.1, height - 0.3, width - 0.1, height - 0.04, 150.0F, 0.8F);  // Against kicks.
  scratches(canvas, random, 6, 0.3);
  canvas.rectangle(0.13, 0.5 * height, 0.27, 0.5 * height + 0.03, 225.0F);
  canvas.disc(0.15, 0.5 * height + 0.1, 0.018, 205.0F);
}

void paint_view(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(222.0F);
  canvas.add_noise(random, 1.0, 9.0F, 0.7F);
  for (double x = 0; x < width; x += random.uniform(0.2, 0.5))
    canvas.rectangle(x, height * random.uniform(0.45, 0.7), x + random.uniform(0.2, 0.6), height,
                     between(random, 110, 165));
  for (int i = 0; i < 60; ++i)
    canvas.disc(random.uniform(0.0, width), height * random.uniform(0.6, 1.0), random.uniform(0.02, 0.06),
                between(random, 60, 130), 0.8F);
  for (const double share : {0.0, 0.5, 1.0})
    canvas.line(share * width, 0, share * width, height, 0.07, share == 0.5 ? 96.0F : 70.0F);
  canvas.outline(0, 0, width, height, 0.1, 74.0F);
}

void paint_tread(Canvas& canvas, Random& random) {
  canvas.fill(118.0F);
  canvas.add_noise(random, 0.5, 10.0F, 0.86F);
  specks(canvas, random, count_on(canvas, 30.0), 100.0F);
  stains(canvas, random, count_on(canvas, 2.0), 0.03, 0.25, 26.0F);
  canvas.rectangle(0, 0, canvas.width(), 0.03, 190.0F, 0.8F);  // The edge.
}

void paint_door_sign(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(205.0F);
  if (width < 0.1) return;
  canvas.rectangle(0, 0, width, 0.3 * height, between(random, 30, 110));
  canvas.text(0.06 * width, 0.05 * height, 0.2 * height, code(random, 1, 3), 235.0F);
  for (double y = 0.42; y < 0.9; y += 0.16)
    canvas.text(0.08 * width, y * height, 0.09 * height, code(random, 5, static_cast<int>(random.below(2))), 30.0F);
}

void paint_poster(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  const bool dark = random.uniform() < 0.5;
  canvas.fill(dark ? between(random, 30, 80) : between(random, 180, 225));
  if (width < 0.2) return;
  for (int i = 3 + static_cast<int>(random.below(4)); i > 0; --i) {
    const double x = random.uniform(0.0, 0.7) * width, y = random.uniform(0.25, 0.8) * height;
    if (random.uniform() < 0.5)
      canvas.disc(x + 0.1, y, random.uniform(0.06, 0.25) * width, between(random, 20, 235), 0.85F);
    else
      canvas.rectangle(x, y, x + random.uniform(0.15, 0.6) * width, y + random.uniform(0.05, 0.3) * height,
                       between(random, 20, 235), 0.85F);
  }
  const float ink = dark ? 225.0F : 25.0F;
  canvas.text(0.07 * width, 0.06 * height, 0.11 * height, code(random, 4, 1), ink);
  for (double y = 0.82; y < 0.95; y += 0.05)
    canvas.text(0.07 * width, y * height, 0.03 * height, code(random, 8, 4), ink, 0.9F);
  canvas.outline(0, 0, width, height, 0.025, dark ? 150.0F : 60.0F);
}

void paint_notice_board(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(105.0F);
  canvas.add_noise(random, 0.1, 12.0F, 0.9F);
  if (width < 0.3) return;
  for (int i = 6 + static_cast<int>(random.below(7)); i > 0; --i) {
    const double w = random.uniform(0.15, 0.32), h = w * random.uniform(0.7, 1.45);
    const double x = random.uniform(0.05, width - w - 0.05),
                 y = random.uniform(0.05, std::max(0.06, height - h - 0.05));
    canvas.rectangle(x + 0.01, y + 0.012, x + w + 0.01, y + h + 0.012, 45.0F, 0.6F);
    label(canvas, random, {x, y, x + w, y + h});
    if (random.uniform() < 0.4) canvas.disc(x + 0.6 * w, y + 0.65 * h, 0.2 * w, between(random, 40, 150));
    canvas.disc(x + 0.5 * w, y + 0.02, 0.012, 20.0F);
  }
  canvas.outline(0, 0, width, height, 0.05, 60.0F);
}

void paint_picture(Canvas& canvas, Random& random) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(between(random, 90, 200));
  canvas.add_noise(random, 0.4, 45.0F, 0.8F);
  for (int i = 0; i < 14; ++i)
    canvas.line(random.uniform(0.0, width), random.uniform(0.0, height), random.uniform(0.0, width),
                random.uniform(0.0, height), random.uniform(0.01, 0.05), between(random, 15, 240), 0.8F);
  canvas.outline(0, 0, width, height, 0.1, 215.0F);
  canvas.outline(0, 0, width, height, 0.04, 35.0F);
}

void paint_pane(Canvas& canvas, Random& random, const Canvas::Box& box) {
  const double width = box.x1 - box.x0, height = box.y1 - box.y0;
  canvas.rectangle(box.x0, box.y0, box.x1, box.y1, between(random, 26, 60));
  for (int i = 0; i < 3; ++i) {
    const double x = box.x0 + width * random.uniform(0.0, 0.7), y = box.y0 + height * random.uniform(0.0, 0.7);
    canvas.rectangle(x, y, x + width * random.uniform(0.1, 0.3), y + height * random.uniform(0.1, 0.3),
                     between(random, 30, 150), 0.6F);
  }
  if (random.uniform() < 0.6) {  // A blind.
    const double low = box.y0 + height * random.uniform(0.1, 0.8);
    for (double y = box.y0; y < low; y += 0.08) canvas.rectangle(box.x0, y, box.x1, y + 0.055, 150.0F);
  }
  canvas.outline(box.x0, box.y0, box.x1, box.y1, 0.07, 178.0F);
  canvas.line(box.x0 + 0.5 * width, box.y0, box.x0 + 0.5 * width, box.y1, 0.05, 170.0F);
  canvas.rectangle(box.x0 - 0.08, box.y1, box.x1 + 0.08, box.y1 + 0.09, 172.0F);
  canvas.rectangle(box.x0 - 0.08, box.y1 + 0.09, box.x1 + 0.08, box.y1 + 0.15, 36.0F, 0.6F);
}

void paint_facade(Canvas& canvas, Random& random, bool brick) {
  const double width = canvas.width(), height = canvas.height();
  const float tone = brick ? 104.0F : 140.0F;
  canvas.fill(tone - 26.0F);
  const double length = brick ? 0.3 : 1.5, row_height = brick ? 0.12 : 0.95, joint = brick ? 0.014 : 0.02;
  int row = 0;
  for (double y = 0; y < height; y += row_height, ++row)
    for (double x = (row & 1) != 0 && brick ? -0.5 * length : 0.0; x < width; x += length)
      canvas.rectangle(x, y, x + length - joint, y + row_height - joint, tone + between(random, -16, 16));
  canvas.add_noise(random, 3.0, 8.0F, 0.84F);
  stains(canvas, random, count_on(canvas, 0.8), 0.06, 0.6, 26.0F);
  drips(canvas, random, count_on(canvas, 0.5), 26.0F);
  specks(canvas, random, count_on(canvas, 4.0), tone);
  if (height > 6.0)
    for (const double top : {1.0, 4.6})
      for (double x = 0.75; x + 2.0 < width; x += 3.0) paint_pane(canvas, random, {x, top, x + 1.6, top + 1.6});
  canvas.rectangle(0, 0, width, 0.25, 60.0F, 0.8F);
  canvas.rectangle(0, height - 0.4, width, height, 72.0F, 0.7F);
}

void paint_asphalt(Canvas& canvas, Random& random) {
  canvas.fill(84.0F);
  canvas.add_noise(random, 3.0, 9.0F, 0.87F);
  for (int i = count_on(canvas, 0.03); i > 0; --i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    const double x1 = x + random.uniform(0.5, 2.0), y1 = y + random.uniform(0.5, 2.5);
    canvas.rectangle(x, y, x1, y1, 84.0F + between(random, -26, 18), 0.7F);
    canvas.outline(x, y, x1, y1, 0.03, 44.0F, 0.7F);
  }
  stains(canvas, random, count_on(canvas, 0.9), 0.05, 0.6, 26.0F);
  cracks(canvas, random, count_on(canvas, 0.16), 2.4, 40.0F);
  specks(canvas, random, count_on(canvas, 10.0), 84.0F);
}

void paint_paving(Canvas& canvas, Random& random) {
  canvas.fill(72.0F);
  for (double y = 0; y < canvas.height(); y += 0.5)
    for (double x = 0; x < canvas.width(); x += 0.5)
      canvas.rectangle(x, y, x + 0.48, y + 0.48, 112.0F + between(random, -16, 16));
  canvas.add_noise(random, 2.0, 8.0F, 0.84F);
  stains(canvas, random, count_on(canvas, 1.2), 0.05, 0.5, 32.0F);
  specks(canvas, random, count_on(canvas, 8.0), 104.0F);
  cracks(canvas, random, count_on(canvas, 0.1), 1.2, 50.0F);
}

Material alike(void (*paint)(Canvas&, Random&), double texels_per_meter, std::uint64_t likeness) {
  Material material{paint, texels_per_meter};
  material.likeness = likeness;
  return material;
}

}  // namespace

Material plaster() { return {paint_corridor_wall, 80.0}; }
Material floor() { return {paint_floor, 60.0}; }
Material ceiling() {
  Material material{paint_ceiling, 50.0};
  material.shines = true;
  return material;
}
Material door(std::uint64_t likeness) { return alike(paint_door, 100.0, likeness); }
Material view() {
  Material material{paint_view, 60.0};
  material.shines = true;
  return material;
}
Material tread() { return alike(paint_tread, 80.0, 40); }
Material door_sign() { return {paint_door_sign, 300.0}; }
Material poster() { return {paint_poster, 160.0}; }
Material notice_board() { return {paint_notice_board, 160.0}; }
Material picture() { return {paint_picture, 120.0}; }
Material facade(bool brick) {
  return {[brick](Canvas& canvas, Random& random) { paint_facade(canvas, random, brick); }, 50.0};
}
Material asphalt() { return {paint_asphalt, 50.0}; }
Material paving() { return {paint_paving, 50.0}; }
Material parking_line() {
  return {[](Canvas& canvas, Random& random) {
            canvas.fill(188.0F);
            stains(canvas, random, 8, 0.03, 0.2, 60.0F);
            specks(canvas, random, 40, 120.0F);
          },
          40.0};
}

}  // namespace rastro::campus
