// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/refinement/photometric_samples.h"

#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

struct Offset {
  int x, y;
};
constexpr std::array<Offset, photometric_pattern_size> pattern = {
    {{0, 0}, {2, 0}, {-2, 0}, {0, 2}, {0, -2}, {1, 1}, {-1, -1}}};
constexpr int border_px = 4;
constexpr std::size_t least_pixels = 50;  // of a pair of keyframes, to know its gain and offset

/// Bilinear.
double intensity_at(const GrayView& image, double x, double y) {
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const double right = x - left, bottom = y - top;
  const std::uint8_t* upper = image.row(top) + left;
  const std::uint8_t* lower = image.row(top + 1) + left;
  return (1.0 - bottom) * ((1.0 - right) * upper[0] + right * upper[1]) +
         bottom * ((1.0 - right) * lower[0] + right * lower[1]);
}

double squared_gradient_at(const GrayView& image, int x, int y) {
  const double across = 0.5 * (image.row(y)[x + 1] - image.row(y)[x - 1]),
               upright = 0.5 * (image.row(y + 1)[x] - image.row(y - 1)[x]);
  return across * across + upright * upright;
}

/// Whether all pixels from the upper left to the lower right one may be used.
bool is_usable(const GrayView& mask, int left, int top, int right, int bottom) {
  if (mask.empty()) return true;
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x)
      if (mask.at(x, y) == 0) return false;
  return true;
}

}  // namespace

std::optional<std::array<double, photometric_pattern_size>> squared_gradients_around(const PhotometricKeyframe& host,
                                                                                     const PhotometricPoint& point) {
  std::array<double, photometric_pattern_size> gradients;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const int x = point.x + pattern[i].x, y = point.y + pattern[i].y;
    if (!is_usable(host.mask, x - 1, y - 1, x + 1, y + 1)) return std::nullopt;
    gradients[i] = squared_gradient_at(host.image, x, y);
  }
  return gradients;
}

PhotometricSampler::PhotometricSampler(const PhotometricKeyframe& host, const PhotometricKeyframe& target,
                                       const Camera& camera)
    : host_(host),
      target_(target),
      camera_(camera),
      target_from_host_(target.camera_from_world * host.camera_from_world.inverse()),
      rotation_(target_from_host_.rotation().matrix()) {}

void PhotometricSampler::add(std::size_t index, std::vector<PhotometricSample>& samples) const {
  const PhotometricPoint& point = host_.points[index];
  const std::size_t before = samples.size();
  for (const Offset& offset : pattern) {
    const auto sample = sample_of(index, point.x + offset.x, point.y + offset.y);
    if (!sample) return samples.resize(before);
    samples.push_back(*sample);
  }
}

std::optional<PhotometricSample> PhotometricSampler::sample_of(std::size_t index, int x, int y) const {
  PhotometricSample sample;
  sample.point = index;
  sample.ray = {(x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy};
  sample.direction =
      rotation_ * sample.ray.homogeneous() + host_.points[index].inverse_depth * target_from_host_.translation();
  if (sample.direction.z() < 1e-3) return std::nullopt;
  const double u = camera_.fx * sample.direction.x() / sample.direction.z() + camera_.cx,
               v = camera_.fy * sample.direction.y() / sample.direction.z() + camera_.cy;
  if (!(u >= border_px && v >= border_px && u < target_.image.width - border_px - 1 &&
        v < target_.image.height - border_px - 1))
    return std::nullopt;
  // With the pixels from which intensities between them and gradients are made.
  const int left = static_cast<int>(u), top = static_cast<int>(v);
  if (!is_usable(host_.mask, x - 1, y - 1, x + 1, y + 1) ||
      !is_usable(target_.mask, left - 1, top - 1, left + 2, top + 2))
    return std::nullopt;
  sample.host = host_.image.row(y)[x];
  sample.squared_gradient = squared_gradient_at(host_.image, x, y);
  sample.target = intensity_at(target_.image, u, v);
  sample.gradient =
      0.5 * Eigen::Vector2d(intensity_at(target_.image, u + 1, v) - intensity_at(target_.image, u - 1, v),
                            intensity_at(target_.image, u, v + 1) - intensity_at(target_.image, u, v - 1));
  return sample;
}

PairBrightness brightness_of(const std::vector<PhotometricSample>& samples, double outlier) {
  PairBrightness brightness;
  if (samples.size() < least_pixels) return brightness;
  for (int round = 0; round < 2; ++round) {
    double n = 0.0, host = 0.0, target = 0.0, squares = 0.0, products = 0.0;
    for (const PhotometricSample& sample : samples) {
      if (round > 0 && std::abs(brightness.residual(sample)) > outlier) continue;
      ++n, host += sample.host, target += sample.target;
      squares += sample.host * sample.host, products += sample.host * sample.target;
    }
    const double spread = squares - host * host / std::max(1.0, n);
    if (!(spread > 1.0)) return brightness;
    brightness.gain = std::clamp((products - host * target / n) / spread, 0.2, 5.0);
    brightness.offset = (target - brightness.gain * host) / n;
  }
  return brightness;
}

}  // namespace rastro
