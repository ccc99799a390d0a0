// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/corridor_materials.h"

#include "rastro/synthetic/paint/details.h"

namespace rastro::corridor {
namespace {

using namespace paint;

float some(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }
int many(const Canvas& canvas, double per_square_meter) {
  return static_cast<int>(canvas.width() * canvas.height() * per_square_meter + 0.5);
}

void notice(Canvas& canvas, Random& random, double x, double y) {
  const double width = random.uniform(0.2, 0.6), height = random.uniform(0.25, 0.8);
  canvas.rectangle(x - 0.01, y - 0.01, x + width + 0.01, y + height + 0.01, some(random, 40, 90));
  canvas.rectangle(x, y, x + width, y + height, some(random, 190, 240));
  canvas.text(x + 0.04, y + 0.04, random.uniform(0.03, 0.07), code(random, 2, 3), 40.0F);
  for (double line = 0.16; line < height - 0.03; line += 0.035)
    canvas.rectangle(x + 0.03, y + line, x + random.uniform(0.4, 0.95) * width, y + line + 0.012, 96.0F);
  if (random.uniform() < 0.5) canvas.disc(x + 0.7 * width, y + 0.6 * height, 0.2 * width, some(random, 60, 150));
}

void paint_wall(Canvas& canvas, Random& random, bool bare) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(168.0F + some(random, -10, 10));
  canvas.add_noise(random, 3.0, 6.0F, 0.86F);
  if (height > 2.0) canvas.rectangle(0, height - 0.10, width, height, 92.0F);
  if (height > 2.0 && width > 1.0 && !bare) {
    for (int i = many(canvas, 0.22); i > 0; --i)
      notice(canvas, random, random.uniform(0.1, width - 0.7), random.uniform(0.6, 1.2));
    for (int i = many(canvas, 0.10); i > 0; --i) {
      const double x = random.uniform(0.1, width - 0.2), y = height - random.uniform(0.25, 0.35);
      canvas.outline(x, y, x + 0.08, y + 0.08, 0.012, 110.0F);
      canvas.disc(x + 0.04, y + 0.04, 0.025, 120.0F);
    }
  }
  specks(canvas, random, many(canvas, bare ? 5.0 : 8.0), 150.0F);
  stains(canvas, random, many(canvas, 0.5), 0.04, 0.4, 18.0F);
  scratches(canvas, random, many(canvas, 0.8), 0.7);
  cracks(canvas, random, many(canvas, 0.08), 0.8, 110.0F);
}

void paint_carpet(Canvas& canvas, Random& random) {
  for (double y = 0; y < canvas.height(); y += 0.5)
    for (double x = 0; x < canvas.width(); x += 0.5)
      canvas.rectangle(x, y, x + 0.5, y + 0.5, 88.0F + some(random, -9, 9));
  canvas.add_noise(random, 1.5, 8.0F, 0.9F);
  specks(canvas, random, many(canvas, 16.0), 88.0F);
  stains(canvas, random, many(canvas, 0.8), 0.05, 0.4, 26.0F);
}

void paint_ceiling(Canvas& canvas, Random& random) {
  const double panel = 0.6;
  canvas.fill(150.0F);
  int column = 0;
  for (double x = 0; x < canvas.width(); x += panel, ++column) {
    int row = 0;
    for (double y = 0; y < canvas.height(); y += panel, ++row) {
      const bool lamp = column % 4 == 1 && row % 4 == 1;
      canvas.rectangle(x + 0.01, y + 0.01, x + panel - 0.01, y + panel - 0.01, lamp ? 250.0F : some(random, 176, 192));
    }
  }
  specks(canvas, random, many(canvas, 20.0), 150.0F);
}

void paint_wood(Canvas& canvas, Random& random, float tone) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(tone);
  canvas.add_noise(random, 0.5, 8.0F, 0.85F);
  for (int i = many(canvas, 22.0); i > 0; --i) {
    const double x = random.uniform(0.0, width), y = random.uniform(0.0, height);
    canvas.line(x, y, x + random.uniform(-0.02, 0.02), y + random.uniform(0.1, 0.6), 0.006, tone - 22.0F, 0.7F);
  }
  canvas.outline(0, 0, width, height, 0.02, tone - 35.0F);
  if (width > 0.7 && height > 1.8) {
    canvas.rectangle(0.08 * width, 0.5 * height, 0.08 * width + 0.14, 0.5 * height + 0.03, 225.0F);
    canvas.text(0.6 * width, 0.2 * height, 0.06, code(random, 1, 3), 30.0F);
  }
}

void paint_metal(Canvas& canvas, Random& random, float tone) {
  const double width = canvas.width(), height = canvas.height();
  canvas.fill(tone);
  canvas.add_noise(random, 0.8, 6.0F, 0.85F);
  for (double y = 0.35; y < height; y += 0.35) seam(canvas, 0, y, width, y, 0.012);
  for (double y = 0.12; y < height && width > 0.3; y += 0.35)
    canvas.rectangle(0.4 * width, y, 0.6 * width, y + 0.02, tone + 60.0F);
  canvas.outline(0, 0, width, height, 0.02, tone - 40.0F);
  scratches(canvas, random, many(canvas, 2.0), 0.4);
}

void paint_cloth(Canvas& canvas, Random& random, float tone) {
  canvas.fill(tone);
  canvas.add_noise(random, 0.3, 22.0F, 0.85F);
}

void paint_leaves(Canvas& canvas, Random& random) {
  canvas.fill(36.0F);
  for (int i = many(canvas, 150.0); i > 0; --i)
    canvas.disc(random.uniform(0.0, canvas.width()), random.uniform(0.0, canvas.height()), random.uniform(0.02, 0.07),
                some(random, 30, 140), 0.8F);
}

}  // namespace

Material wall(bool bare) {
  return {[bare](Canvas& canvas, Random& random) { paint_wall(canvas, random, bare); }, 90.0};
}
Material carpet() { return {paint_carpet, 70.0}; }
Material ceiling() { return {paint_ceiling, 50.0, true}; }
Material wood(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_wood(canvas, random, tone); }, 110.0};
}
Material metal(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_metal(canvas, random, tone); }, 110.0};
}
Material cloth(float tone) {
  return {[tone](Canvas& canvas, Random& random) { paint_cloth(canvas, random, tone); }, 110.0};
}
Material skin() { return cloth(170.0F); }
Material leaves() { return {paint_leaves, 70.0}; }

}  // namespace rastro::corridor
