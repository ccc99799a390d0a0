// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/sensor_model.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr int rows_per_task = 16;
constexpr float least_blur_px = 0.3F;  // Shorter blur changes intensities by less than the noise.

/// Flow of pixels during the exposure (Longuet-Higgins and Prazdny 1980), without lens distortion: over the short path
/// of a blur it changes the length by only a few per cent.
class BlurField {
 public:
  BlurField(const Camera& camera, const ShutterMotion& shutter)
      : fx_(static_cast<float>(camera.fx)),
        fy_(static_cast<float>(camera.fy)),
        cx_(static_cast<float>(camera.cx)),
        cy_(static_cast<float>(camera.cy)) {
    for (int i = 0; i < 6; ++i) motion_[i] = static_cast<float>(shutter.motion[i]);
  }
  void at(int px, int py, float depth, float& flow_x, float& flow_y) const {
    const float x = (static_cast<float>(px) - cx_) / fx_, y = (static_cast<float>(py) - cy_) / fy_;
    const float inverse = depth > 0.0F ? 1.0F / depth : 0.0F;
    const float* v = motion_;
    const float* w = motion_ + 3;
    flow_x = fx_ * ((x * v[2] - v[0]) * inverse + x * y * w[0] - (1.0F + x * x) * w[1] + y * w[2]);
    flow_y = fy_ * ((y * v[2] - v[1]) * inverse + (1.0F + y * y) * w[0] - x * y * w[1] - x * w[2]);
  }

 private:
  float fx_, fy_, cx_, cy_;
  float motion_[6];
};

float light_between(const Image<float>& light, float x, float y) {
  x = std::clamp(x, 0.0F, static_cast<float>(light.width() - 1));
  y = std::clamp(y, 0.0F, static_cast<float>(light.height() - 1));
  const int left = std::min(static_cast<int>(x), light.width() - 2),
            top = std::min(static_cast<int>(y), light.height() - 2);
  const float u = x - static_cast<float>(left), v = y - static_cast<float>(top);
  const float* upper = light.row(top) + left;
  const float* lower = light.row(top + 1) + left;
  const float above = upper[0] + u * (upper[1] - upper[0]);
  const float below = lower[0] + u * (lower[1] - lower[0]);
  return above + v * (below - above);
}

float blurred(const Image<float>& light, int x, int y, float flow_x, float flow_y) {
  const float length = std::sqrt(flow_x * flow_x + flow_y * flow_y);
  if (length < least_blur_px) return light.at(x, y);
  const int probes = std::min(32, 2 + static_cast<int>(length));
  float sum = 0.0F;
  for (int probe = 0; probe < probes; ++probe) {
    const float along = (static_cast<float>(probe) + 0.5F) / static_cast<float>(probes) - 0.5F;
    sum += light_between(light, static_cast<float>(x) + along * flow_x, static_cast<float>(y) + along * flow_y);
  }
  return sum / static_cast<float>(probes);
}

using Channels = Eigen::Array4f;

Channels channels_at(const Image<float>& light, int x, int y) {
  return Eigen::Map<const Channels, Eigen::Aligned16>(light.row(y) + 4 * x);
}

Channels channels_between(const Image<float>& light, float x, float y) {
  const int width = light.width() / 4;
  x = std::clamp(x, 0.0F, static_cast<float>(width - 1));
  y = std::clamp(y, 0.0F, static_cast<float>(light.height() - 1));
  const int left = std::min(static_cast<int>(x), width - 2), top = std::min(static_cast<int>(y), light.height() - 2);
  const float u = x - static_cast<float>(left), v = y - static_cast<float>(top);
  const Channels upper = channels_at(light, left, top), lower = channels_at(light, left, top + 1);
  const Channels above = upper + u * (channels_at(light, left + 1, top) - upper);
  const Channels below = lower + u * (channels_at(light, left + 1, top + 1) - lower);
  return above + v * (below - above);
}

Channels blurred_channels(const Image<float>& light, int x, int y, float flow_x, float flow_y) {
  const float length = std::sqrt(flow_x * flow_x + flow_y * flow_y);
  if (length < least_blur_px) return channels_at(light, x, y);
  const int probes = std::min(24, 2 + static_cast<int>(0.5F * length));
  Channels sum = Channels::Zero();
  for (int probe = 0; probe < probes; ++probe) {
    const float along = (static_cast<float>(probe) + 0.5F) / static_cast<float>(probes) - 0.5F;
    sum += channels_between(light, static_cast<float>(x) + along * flow_x, static_cast<float>(y) + along * flow_y);
  }
  return sum / static_cast<float>(probes);
}

/// Standard normal to the precision of 8-bit images: the sum of four uniform 16-bit numbers (Irwin and Hall).
float quick_normal(Random& random) {
  const std::uint64_t bits = random.next();
  const auto sum =
      static_cast<std::int32_t>((bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) + ((bits >> 32) & 0xFFFF) + (bits >> 48));
  return static_cast<float>(sum - 131070) * (1.0F / 37837.2F);
}

/// The same from a list of 4096 that is drawn once: 12 bits per number.
class NormalList {
 public:
  NormalList() {
    Random random(1);
    for (float& value : values_) value = quick_normal(random);
  }
  float at(std::uint64_t bits) const { return values_[bits & 4095]; }

 private:
  std::array<float, 4096> values_;
};

/// Calls draw(random, x, y, flow_x, flow_y, falloff) for every pixel of an image; each row has its own generator, so
/// that rows can be drawn in parallel. The flow is the blur in pixels, falloff the share of light after vignetting.
template <typename Draw>
void for_each_pixel(const DepthImage& depth, const Camera& camera, const SensorModel& sensor,
                    const ShutterMotion& shutter, std::uint64_t noise_seed, TaskPool& pool, int width, int height,
                    const Draw& draw) {
  const BlurField field(camera, shutter);
  const float middle_x = 0.5F * static_cast<float>(width - 1), middle_y = 0.5F * static_cast<float>(height - 1);
  const float to_corner = 1.0F / (middle_x * middle_x + middle_y * middle_y);
  pool.for_chunks(0, height, rows_per_task, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      Random random(seed_for(noise_seed, static_cast<std::uint64_t>(y)));
      const float dy = static_cast<float>(y) - middle_y;
      for (int x = 0; x < width; ++x) {
        float flow_x = 0.0F, flow_y = 0.0F;
        if (sensor.exposure_time_s > 0.0) field.at(x, y, depth.at(x, y), flow_x, flow_y);
        const float dx = static_cast<float>(x) - middle_x;
        const float falloff = 1.0F - sensor.vignette * (dx * dx + dy * dy) * to_corner;
        draw(random, x, y, flow_x, flow_y, falloff);
      }
    }
  });
}

}  // namespace

GrayImage expose(const Image<float>& light, const DepthImage& depth, const Camera& camera, const SensorModel& sensor,
                 const ShutterMotion& shutter, std::uint64_t noise_seed, TaskPool& pool) {
  const int width = light.width(), height = light.height();
  GrayImage gray(width, height);
  if (width < 2 || height < 2) return gray;
  const auto draw = [&](Random& random, int x, int y, float flow_x, float flow_y, float falloff) {
    const float value = std::min(255.0F, blurred(light, x, y, flow_x, flow_y) * sensor.gain * falloff);
    const float sigma = std::sqrt(sensor.read_noise * sensor.read_noise + sensor.shot_noise * value);
    gray.at(x, y) = static_cast<std::uint8_t>(std::clamp(value + sigma * quick_normal(random) + 0.5F, 0.0F, 255.0F));
  };
  for_each_pixel(depth, camera, sensor, shutter, noise_seed, pool, width, height, draw);
  return gray;
}

ColorImage expose_color(const Image<float>& light, const DepthImage& depth, const Camera& camera,
                        const SensorModel& sensor, const ShutterMotion& shutter, std::uint64_t noise_seed,
                        TaskPool& pool) {
  const int width = light.width() / 4, height = light.height();
  ColorImage color{Image<std::uint8_t>(3 * width, height)};
  if (width < 2 || height < 2) return color;
  const NormalList normals;
  const auto draw = [&](Random& random, int x, int y, float flow_x, float flow_y, float falloff) {
    const std::uint64_t bits = random.next();
    Channels value = (blurred_channels(light, x, y, flow_x, flow_y) * (sensor.gain * falloff)).min(255.0F);
    const Channels sigma = (sensor.read_noise * sensor.read_noise + sensor.shot_noise * value).sqrt();
    value += sigma * Channels(normals.at(bits), normals.at(bits >> 12), normals.at(bits >> 24), 0.0F) + 0.5F;
    value = value.max(0.0F).min(255.0F);
    for (int channel = 0; channel < 3; ++channel)
      color.rgb.at(3 * x + channel, y) = static_cast<std::uint8_t>(value[channel]);
  };
  for_each_pixel(depth, camera, sensor, shutter, noise_seed, pool, width, height, draw);
  return color;
}

}  // namespace rastro
