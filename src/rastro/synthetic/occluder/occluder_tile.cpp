// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/occluder/occluder_tile.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/synthetic/occluder/outline.h"

namespace rastro {
namespace {

using Eigen::Vector2d;

/// Value noise in -1 .. 1, smooth between the points of a unit lattice.
double lattice_noise(std::uint64_t seed, double x, double y) {
  const double column = std::floor(x), line = std::floor(y);
  const double u = x - column, v = y - line;
  const double s = u * u * (3 - 2 * u), t = v * v * (3 - 2 * v);
  const auto corner = [&](double dx, double dy) {
    const auto cell_x = static_cast<std::uint64_t>(static_cast<std::int64_t>(column + dx));
    const auto cell_y = static_cast<std::uint64_t>(static_cast<std::int64_t>(line + dy));
    return static_cast<double>(seed_for(seed_for(seed, cell_x), cell_y) >> 11) * 0x1.0p-52 - 1.0;
  };
  const double above = corner(0, 0) + s * (corner(1, 0) - corner(0, 0));
  const double below = corner(0, 1) + s * (corner(1, 1) - corner(0, 1));
  return above + t * (below - above);
}

/// A printed patch: a rotated rectangle or a disc of one tone.
struct Patch {
  Vector2d center, half_size, along;
  double tone = 0.0;
  bool disc = false;

  /// 1 inside, 0 outside, with a soft border of `softness` (in widths, like all lengths here).
  double cover(const Vector2d& position, double softness) const {
    const Vector2d offset = position - center;
    const Vector2d local(offset.dot(along), offset.x() * -along.y() + offset.y() * along.x());
    const double outside = disc ? local.norm() - half_size.x() : (local.cwiseAbs() - half_size).maxCoeff();
    return std::clamp(0.5 - outside / softness, 0.0, 1.0);
  }
};

/// The texture of one occluder, at positions in units of its width.
class Texture {
 public:
  explicit Texture(const OccluderAppearance& appearance) : patch_(appearance), pixel_(1.0 / appearance.width_px) {
    Random random(appearance.seed);
    for (double& tone : part_tones_) tone = random.uniform(-0.5, 0.5);
    part_tones_[static_cast<std::size_t>(OccluderPart::hair)] = -0.9;
    part_tones_[static_cast<std::size_t>(OccluderPart::skin)] = 0.3;
    stripes_ = random.uniform() < 0.5 ? random.uniform(7.0, 12.0) : 0.0;
    const double height = appearance.height_px * pixel_;
    const int count = static_cast<int>(std::clamp(40.0 * height, 20.0, 200.0));
    for (int i = 0; i < count; ++i) {
      Patch patch;
      patch.center = {random.uniform(-0.5, 0.5), random.uniform(0.0, height)};
      const double size = 0.025 + 0.11 * std::pow(random.uniform(), 2.0);
      patch.half_size = {size, size * random.uniform(0.4, 1.0)};
      const double angle = random.uniform(-0.5, 0.5);
      patch.along = {std::cos(angle), std::sin(angle)};
      patch.tone = (random.uniform() < 0.5 ? -1.0 : 1.0) * random.uniform(0.3, 1.1);
      patch.disc = random.uniform() < 0.25;
      add(patch);
    }
  }

  /// Intensity at `distance` (below 0: inside) from the outline.
  double gray(const Vector2d& position, const OutlineDistance& outline) const {
    double tone = part_tones_[static_cast<std::size_t>(outline.part)];
    const bool printed = outline.part == OccluderPart::shirt || outline.part == OccluderPart::post;
    if (stripes_ > 0.0 && printed) tone += 0.35 * std::clamp(4.0 * std::sin(position.y() * 2.0 * stripes_), -1.0, 1.0);
    if (printed || outline.part == OccluderPart::trousers) tone = print(position, tone, printed ? 1.0 : 0.6);
    double noise = 0.0, strength = 0.4, scale = 4.0;
    for (std::uint64_t octave = 0; octave < 5; ++octave, scale *= 2.1, strength *= 0.8)
      noise +=
          strength * lattice_noise(seed_for(patch_.seed, 100 + octave), position.x() * scale, position.y() * scale);
    // Round bodies get darker towards their outline, on one side more than on the other.
    const double depth = std::clamp(-outline.distance / 0.18, 0.0, 1.0);
    const double shade = 0.72 + 0.28 * std::sqrt(depth) - 0.16 * position.x();
    return std::clamp((patch_.brightness + patch_.contrast * (tone + noise)) * shade, 4.0, 250.0);
  }

 private:
  static std::size_t band_of(double y) { return static_cast<std::size_t>(std::max(0.0, y / reach + 1.0)); }

  /// Added to each band of rows that it may touch.
  void add(const Patch& patch) {
    const std::size_t last = band_of(patch.center.y() + reach);
    if (bands_.size() <= last) bands_.resize(last + 1);
    for (std::size_t band = band_of(patch.center.y() - reach); band <= last; ++band) bands_[band].push_back(patch);
  }

  double print(const Vector2d& position, double tone, double strength) const {
    const std::size_t band = band_of(position.y());
    if (band >= bands_.size()) return tone;
    for (const Patch& patch : bands_[band])
      if ((position - patch.center).squaredNorm() < reach * reach)
        tone += strength * patch.cover(position, 1.5 * pixel_) * (patch.tone - tone);
    return tone;
  }

  static constexpr double reach = 0.2;  ///< Largest radius of a patch.

  const OccluderAppearance& patch_;
  double pixel_;
  std::array<double, 5> part_tones_{};
  double stripes_ = 0.0;
  std::vector<std::vector<Patch>> bands_;
};

/// Mean over `length` pixels along each row, ends weighted by their fraction.
void blur_along_rows(Image<float>& image, double length) {
  const int reach = static_cast<int>(std::ceil(length / 2.0));
  std::vector<float> row(static_cast<std::size_t>(image.width()));
  for (int y = 0; y < image.height(); ++y) {
    std::copy_n(image.row(y), image.width(), row.begin());
    for (int x = 0; x < image.width(); ++x) {
      double sum = 0.0, weights = 0.0;
      for (int d = -reach; d <= reach; ++d) {
        const double weight = std::clamp(length / 2.0 + 0.5 - std::abs(d), d == 0 ? 1e-6 : 0.0, 1.0);
        weights += weight;
        if (x + d >= 0 && x + d < image.width()) sum += weight * row[static_cast<std::size_t>(x + d)];
      }
      image.at(x, y) = static_cast<float>(sum / weights);
    }
  }
}

}  // namespace

OccluderTile paint_occluder(const OccluderAppearance& appearance) {
  const double lean = std::abs(std::tan(appearance.tilt_rad)) * appearance.height_px;
  const int margin = static_cast<int>(std::ceil(appearance.blur_px)) + 4;
  const int width = static_cast<int>(std::ceil(appearance.width_px * 1.15 + lean)) + 2 * margin;
  const int height = static_cast<int>(std::ceil(appearance.height_px));
  OccluderTile tile{Image<float>(width, height), Image<float>(width, height)};
  const Texture texture(appearance);
  const double sway = Random(seed_for(appearance.seed, 7)).uniform(-1.0, 1.0);
  const double cosine = std::cos(appearance.tilt_rad), sine = std::sin(appearance.tilt_rad);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      // Tilts about the image's middle row, so that it is not shifted as a whole.
      const double dx = x - (width - 1) / 2.0, dy = y - height / 2.0;
      const Vector2d position((cosine * dx + sine * dy) / appearance.width_px,
                              (cosine * dy - sine * dx + height / 2.0) / appearance.width_px);
      const OutlineDistance outline = outline_distance(appearance.shape, position, sway);
      // A lens is never perfectly sharp: 2 px from nothing to full.
      const double opacity = std::clamp(0.5 - outline.distance * appearance.width_px / 2.0, 0.0, 1.0);
      if (opacity <= 0.0) continue;
      tile.opacity.at(x, y) = static_cast<float>(opacity);
      tile.gray.at(x, y) = static_cast<float>(opacity * texture.gray(position, outline));
    }
  }
  blur_along_rows(tile.gray, appearance.blur_px);
  blur_along_rows(tile.opacity, appearance.blur_px);
  return tile;
}

}  // namespace rastro
