// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/paint/details.h"

#include <numbers>

namespace rastro::paint {
namespace {

float shade(Random& random, float low, float high) { return static_cast<float>(random.uniform(low, high)); }

}  // namespace

void bolt(Canvas& canvas, double x, double y, double radius, float tone) {
  canvas.disc(x + 0.35 * radius, y + 0.45 * radius, 1.15 * radius, tone - 60.0F, 0.8F);
  canvas.disc(x, y, radius, tone + 25.0F);
  canvas.line(x - 0.5 * radius, y - 0.3 * radius, x + 0.5 * radius, y + 0.3 * radius, 0.3 * radius, tone - 50.0F);
}

void bolt_row(Canvas& canvas, double x0, double y0, double x1, double y1, double spacing, double radius, float tone) {
  const double length = std::hypot(x1 - x0, y1 - y0);
  const int count = std::max(1, static_cast<int>(length / spacing));
  for (int i = 0; i <= count; ++i) {
    const double along = static_cast<double>(i) / count;
    bolt(canvas, x0 + along * (x1 - x0), y0 + along * (y1 - y0), radius, tone);
  }
}

void seam(Canvas& canvas, double x0, double y0, double x1, double y1, double thickness) {
  canvas.line(x0 + thickness, y0 + thickness, x1 + thickness, y1 + thickness, thickness, 215.0F, 0.35F);
  canvas.line(x0, y0, x1, y1, thickness, 18.0F, 0.85F);
}

void cover(Canvas& canvas, Random& random, const Canvas::Box& box, float tone) {
  const double inset = 0.02 + 0.01 * random.uniform();
  canvas.rectangle(box.x0 + 0.008, box.y0 + 0.012, box.x1 + 0.008, box.y1 + 0.012, tone - 70.0F, 0.6F);
  canvas.rectangle(box.x0, box.y0, box.x1, box.y1, tone, 0.75F);
  canvas.outline(box.x0, box.y0, box.x1, box.y1, 0.006, tone - 75.0F, 0.8F);
  for (const double x : {box.x0 + inset, box.x1 - inset})
    for (const double y : {box.y0 + inset, box.y1 - inset}) bolt(canvas, x, y, 0.009, tone);
}

void vent(Canvas& canvas, Random& random, const Canvas::Box& box, float tone) {
  cover(canvas, random, box, tone + 8.0F);
  const double pitch = random.uniform(0.025, 0.05), margin = 0.05;
  const double height = (0.45 + 0.2 * random.uniform()) * pitch;
  const bool split = random.uniform() < 0.5 && box.x1 - box.x0 > 0.3;
  const double middle = 0.5 * (box.x0 + box.x1);
  for (double y = box.y0 + margin; y + height < box.y1 - margin; y += pitch) {
    canvas.rectangle(box.x0 + margin, y, split ? middle - 0.02 : box.x1 - margin, y + height, 22.0F);
    if (split) canvas.rectangle(middle + 0.02, y, box.x1 - margin, y + height, 22.0F);
    canvas.rectangle(box.x0 + margin, y + height, box.x1 - margin, y + height + 0.006, tone + 50.0F, 0.6F);
  }
}

void label(Canvas& canvas, Random& random, const Canvas::Box& box) {
  const float paper = shade(random, 165, 235), ink = shade(random, 10, 50);
  const double width = box.x1 - box.x0, height = box.y1 - box.y0;
  canvas.rectangle(box.x0, box.y0, box.x1, box.y1, paper);
  canvas.outline(box.x0 + 0.05 * width, box.y0 + 0.06 * height, box.x1 - 0.05 * width, box.y1 - 0.06 * height,
                 0.02 * width, ink);
  const std::string heading = code(random, 2, 2 + static_cast<int>(random.below(2)));
  const double letter = std::min(0.4 * height, 0.8 * width / (6.0 * static_cast<double>(heading.size())) * 7.0);
  canvas.text(box.x0 + 0.12 * width, box.y0 + 0.16 * height, letter, heading, ink);
  double y = box.y0 + 0.22 * height + letter;
  for (; y < box.y1 - 0.18 * height; y += 0.11 * height)
    canvas.line(box.x0 + 0.12 * width, y, box.x0 + random.uniform(0.45, 0.86) * width, y, 0.035 * height, ink, 0.8F);
}

void gauge(Canvas& canvas, Random& random, double x, double y, double radius) {
  canvas.disc(x + 0.1 * radius, y + 0.12 * radius, 1.1 * radius, 25.0F, 0.6F);
  canvas.disc(x, y, radius, shade(random, 190, 240));
  canvas.ring(x, y, radius, 0.14 * radius, 35.0F);
  for (int tick = 0; tick <= 10; ++tick) {
    const double angle = std::numbers::pi * (0.75 + 0.15 * tick);
    canvas.line(x + 0.68 * radius * std::cos(angle), y + 0.68 * radius * std::sin(angle),
                x + 0.85 * radius * std::cos(angle), y + 0.85 * radius * std::sin(angle), 0.06 * radius, 30.0F);
  }
  const double needle = std::numbers::pi * random.uniform(0.8, 2.2);
  canvas.line(x, y, x + 0.62 * radius * std::cos(needle), y + 0.62 * radius * std::sin(needle), 0.09 * radius, 15.0F);
  canvas.disc(x, y, 0.12 * radius, 15.0F);
}

void buttons(Canvas& canvas, Random& random, const Canvas::Box& box) {
  cover(canvas, random, box, shade(random, 60, 190));
  const double pitch = random.uniform(0.055, 0.085), margin = 0.055;
  for (double y = box.y0 + margin; y < box.y1 - margin; y += pitch)
    for (double x = box.x0 + margin; x < box.x1 - margin; x += pitch) {
      if (random.uniform() < 0.2) continue;
      const float tone = random.uniform() < 0.5 ? shade(random, 10, 70) : shade(random, 180, 250);
      if (random.uniform() < 0.5)
        canvas.disc(x, y, 0.28 * pitch, tone);
      else
        canvas.rectangle(x - 0.28 * pitch, y - 0.2 * pitch, x + 0.28 * pitch, y + 0.2 * pitch, tone);
      canvas.line(x - 0.25 * pitch, y + 0.38 * pitch, x + 0.2 * pitch, y + 0.38 * pitch, 0.006, 235.0F, 0.6F);
    }
}

void hazard_band(Canvas& canvas, Random& random, const Canvas::Box& box) {
  canvas.stripes(box.x0, box.y0, box.x1, box.y1, random.uniform(0.14, 0.22), 28.0F, 205.0F);
}

void stains(Canvas& canvas, Random& random, int count, double smallest, double largest, float strength) {
  for (int i = 0; i < count; ++i) {
    const double radius = smallest * std::pow(largest / smallest, random.uniform());
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    const float delta = random.uniform() < 0.75 ? -shade(random, 0.3F, 1.0F) : shade(random, 0.2F, 0.6F);
    for (int part = 0; part < 4; ++part)
      canvas.spot(x + radius * random.uniform(-0.7, 0.7), y + radius * random.uniform(-0.7, 0.7),
                  radius * random.uniform(0.3, 0.9), radius * random.uniform(0.3, 0.9), delta * strength * 0.5F);
  }
}

void specks(Canvas& canvas, Random& random, int count, float tone) {
  for (int i = 0; i < count; ++i) {
    const double radius = 0.002 * std::pow(15.0, random.uniform() * random.uniform());
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    const float change = random.uniform() < 0.65 ? -shade(random, 25, 80) : shade(random, 25, 80);
    if (random.uniform() < 0.5) {
      canvas.disc(x, y, radius, tone + change, 0.85F);
    } else {
      const double angle = random.uniform(0.0, std::numbers::pi), reach = 2.2 * radius;
      canvas.line(x, y, x + reach * std::cos(angle), y + reach * std::sin(angle), 1.2 * radius, tone + change, 0.85F);
    }
  }
}

void drips(Canvas& canvas, Random& random, int count, float strength) {
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(0.0, canvas.width()), top = random.uniform(0.0, 0.7 * canvas.height());
    const double length = random.uniform(0.1, 0.6), width = random.uniform(0.004, 0.02);
    canvas.spot(x, top + 0.4 * length, width, 0.4 * length, -strength * shade(random, 0.4F, 1.0F));
  }
}

void scratches(Canvas& canvas, Random& random, int count, double longest) {
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    const double angle = random.uniform(0.0, 2.0 * std::numbers::pi), length = longest * random.uniform(0.1, 1.0);
    const float tone = random.uniform() < 0.6 ? shade(random, 170, 235) : shade(random, 20, 60);
    canvas.line(x, y, x + length * std::cos(angle), y + length * std::sin(angle), random.uniform(0.002, 0.006), tone,
                shade(random, 0.3F, 0.8F));
  }
}

void cracks(Canvas& canvas, Random& random, int count, double longest, float tone) {
  for (int i = 0; i < count; ++i) {
    double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
    double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
    const int steps = 6 + static_cast<int>(random.below(14));
    for (int step = 0; step < steps; ++step) {
      angle += random.uniform(-0.7, 0.7);
      const double next_x = x + longest / 14.0 * std::cos(angle), next_y = y + longest / 14.0 * std::sin(angle);
      canvas.line(x, y, next_x, next_y, 0.012 * (1.1 - static_cast<double>(step) / steps), tone, 0.8F);
      x = next_x, y = next_y;
    }
  }
}

void cables(Canvas& canvas, Random& random, int count, float tone) {
  for (int i = 0; i < count; ++i) {
    double x = random.uniform(0.1, 0.9) * canvas.width(), y = 0.0;
    const double thickness = random.uniform(0.012, 0.03), sway = random.uniform(0.02, 0.09),
                 phase = random.uniform(0.0, 6.0);
    const double start = x;
    for (int step = 1; step <= 40; ++step) {
      const double next_y = canvas.height() * step / 40.0, next_x = start + sway * std::sin(phase + 7.0 * next_y);
      canvas.line(x + 0.01, y + 0.01, next_x + 0.01, next_y + 0.01, thickness, 25.0F, 0.35F);
      canvas.line(x, y, next_x, next_y, thickness, tone);
      canvas.line(x - 0.25 * thickness, y, next_x - 0.25 * thickness, next_y, 0.25 * thickness, tone + 70.0F, 0.6F);
      if (step % 8 == 0) canvas.rectangle(next_x - 0.035, next_y - 0.012, next_x + 0.035, next_y + 0.012, 190.0F);
      x = next_x, y = next_y;
    }
  }
}

void worn_edges(Canvas& canvas, Random& random, float tone) {
  const double width = canvas.width(), height = canvas.height(), around = 2.0 * (width + height);
  const int count = static_cast<int>(around * 14.0);
  for (int i = 0; i < count; ++i) {
    double along = random.uniform(0.0, around);
    double x = 0.0, y = 0.0;
    if (along < width)
      x = along;
    else if ((along -= width) < height)
      x = width, y = along;
    else if ((along -= height) < width)
      x = along, y = height;
    else
      y = along - width;
    canvas.disc(x, y, 0.02 * random.uniform() * random.uniform() + 0.003, tone, shade(random, 0.3F, 0.9F));
  }
}

namespace {

/// One of many details drawn on a panel.
void panel_detail(Canvas& canvas, Random& random, const Canvas::Box& inner, float tone) {
  const double size = std::min(inner.x1 - inner.x0, inner.y1 - inner.y0);
  const double at_x = random.uniform(inner.x0, inner.x1 - 0.5 * size),
               at_y = random.uniform(inner.y0, inner.y1 - 0.5 * size);
  switch (random.below(9)) {
    case 0:
      vent(canvas, random, inner, tone - 10.0F);
      break;
    case 1:
      cover(canvas, random, inner, tone + shade(random, -55, 60));
      break;
    case 2:
      buttons(canvas, random, {at_x, at_y, at_x + 0.5 * size + 0.08, at_y + 0.5 * size});
      break;
    case 3:
      gauge(canvas, random, at_x + 0.25 * size, at_y + 0.25 * size, std::min(0.12, 0.25 * size));
      break;
    case 4:
      label(canvas, random, {at_x, at_y, at_x + std::min(0.3, 0.5 * size), at_y + std::min(0.2, 0.35 * size)});
      break;
    case 5:
      canvas.text(at_x, at_y, std::min(0.16, 0.2 * size), code(random, 2, 3), random.uniform() < 0.5 ? 230.0F : 25.0F);
      break;
    case 6:
      hazard_band(canvas, random, {inner.x0, inner.y1 - 0.12, inner.x1, inner.y1});
      break;
    case 7:
      cover(canvas, random, inner, tone + shade(random, -30, 30));
      label(canvas, random, {at_x, at_y, at_x + std::min(0.25, 0.45 * size), at_y + std::min(0.16, 0.3 * size)});
      break;
    default:
      bolt_row(canvas, inner.x0, inner.y0, inner.x1, inner.y0, 0.12, 0.011, tone);
      break;
  }
}

}  // namespace

void panels(Canvas& canvas, Random& random, const Canvas::Box& box, float tone, double smallest) {
  const double width = box.x1 - box.x0, height = box.y1 - box.y0, longer = std::max(width, height);
  if (longer > 2.2 * smallest || (longer > 1.2 * smallest && random.uniform() < 0.75)) {
    const double cut = random.uniform(0.35, 0.65);
    Canvas::Box first = box, second = box;
    if (width > height)
      first.x1 = second.x0 = box.x0 + cut * width;
    else
      first.y1 = second.y0 = box.y0 + cut * height;
    panels(canvas, random, first, tone, smallest);
    panels(canvas, random, second, tone, smallest);
    seam(canvas, second.x0, second.y0, width > height ? second.x0 : second.x1, width > height ? second.y1 : second.y0,
         0.007);
    return;
  }
  const double gap = 0.06 * std::min(width, height) + 0.015;
  const Canvas::Box inner{box.x0 + gap, box.y0 + gap, box.x1 - gap, box.y1 - gap};
  if (inner.x1 - inner.x0 < 0.06 || inner.y1 - inner.y0 < 0.06) return;
  panel_detail(canvas, random, inner, tone);
}

std::string code(Random& random, int letters, int digits) {
  std::string result;
  for (int i = 0; i < letters; ++i) result += static_cast<char>('A' + random.below(26));
  if (letters > 0 && digits > 0 && random.uniform() < 0.5) result += '-';
  for (int i = 0; i < digits; ++i) result += static_cast<char>('0' + random.below(10));
  return result;
}

}  // namespace rastro::paint
