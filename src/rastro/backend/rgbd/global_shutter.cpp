// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/global_shutter.h"

#include <algorithm>
#include <vector>

#include "rastro/math/so3.h"

namespace rastro {
namespace {

/// Where the camera recorded what the middle row's instant has at a pixel, and the factor from its depth to that then.
struct Source {
  float x = 0.0F, y = 0.0F, depth_factor = 1.0F;
};

Source mixed(const Source& a, const Source& b, float share) {
  const auto mix = [share](float from, float to) { return from + share * (to - from); };
  return {mix(a.x, b.x), mix(a.y, b.y), mix(a.depth_factor, b.depth_factor)};
}

class RowShifts {
 public:
  RowShifts(const Camera& camera, const Eigen::Vector3d& camera_rotation)
      : camera_(camera), rotation_(camera_rotation) {
    for (int y = 0; y <= (camera.height + step - 1) / step; ++y)
      for (int x = 0; x < columns(); ++x) nodes_.push_back(source_of(x * step, y * step));
    of_row_.resize(static_cast<std::size_t>(columns()));
  }

  /// Of each pixel of a row.
  void sources(int y, std::vector<Source>& row) {
    const auto down = static_cast<float>(y % step) / step;
    const Source* above = nodes_.data() + y / step * columns();
    for (int k = 0; k < columns(); ++k)
      of_row_[static_cast<std::size_t>(k)] = mixed(above[k], above[columns() + k], down);
    for (int x = 0; x < camera_.width; ++x) {
      const Source* left = of_row_.data() + x / step;
      row[static_cast<std::size_t>(x)] = mixed(left[0], left[1], static_cast<float>(x % step) / step);
    }
  }

 private:
  /// The shift changes slowly across the image, and lenses cost time.
  static constexpr int step = 16;

  int columns() const { return (camera_.width + step - 1) / step + 1; }

  /// The row in which it was read depends on where it is then. The pixel itself outside the lens model.
  Source source_of(int x, int y) const {
    const Source same{static_cast<float>(x), static_cast<float>(y)};
    const auto ray = camera_.unproject({x, y});
    if (!ray) return same;
    Eigen::Vector2d pixel(x, y);
    Eigen::Vector3d then = ray->homogeneous();
    for (int iteration = 0; iteration < 3; ++iteration) {
      const double after_middle_s = (pixel.y() / (camera_.height - 1) - 0.5) * camera_.readout_s;
      then = SO3::exp(-after_middle_s * rotation_) * Eigen::Vector3d(ray->homogeneous());
      const auto moved = camera_.project(then);
      if (!moved) return same;
      pixel = *moved;
    }
    return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), static_cast<float>(1.0 / then.z())};
  }

  const Camera& camera_;
  Eigen::Vector3d rotation_;
  std::vector<Source> nodes_, of_row_;  ///< Row by row; between two rows of them.
};

/// Bilinear; `channels` interleaved.
void resample(const Image<std::uint8_t>& from, int y, const std::vector<Source>& row, int channels,
              Image<std::uint8_t>& to) {
  const int width = from.width() / channels, height = from.height();
  std::uint8_t* out = to.row(y);
  for (int x = 0; x < width; ++x) {
    const Source& source = row[static_cast<std::size_t>(x)];
    const float u = std::clamp(source.x, 0.0F, static_cast<float>(width - 1)),
                v = std::clamp(source.y, 0.0F, static_cast<float>(height - 1));
    const int left = std::min(static_cast<int>(u), width - 2), top = std::min(static_cast<int>(v), height - 2);
    const float right = u - static_cast<float>(left), down = v - static_cast<float>(top);
    for (int c = 0; c < channels; ++c) {
      const std::uint8_t *a = from.row(top) + left * channels + c, *b = from.row(top + 1) + left * channels + c;
      const float above = static_cast<float>(a[0]) + right * static_cast<float>(a[channels] - a[0]),
                  below = static_cast<float>(b[0]) + right * static_cast<float>(b[channels] - b[0]);
      out[x * channels + c] = static_cast<std::uint8_t>(above + down * (below - above) + 0.5F);
    }
  }
}

/// The nearest pixel: between two surfaces there is none. nullptr outside.
template <typename T>
const T* nearest(const Image<T>& from, const Source& source) {
  const float x = source.x + 0.5F, y = source.y + 0.5F;
  if (!(x >= 0.0F && y >= 0.0F && x < static_cast<float>(from.width()) && y < static_cast<float>(from.height())))
    return nullptr;
  return &from.at(static_cast<int>(x), static_cast<int>(y));
}

void resample_depth(const DepthImage& from, int y, const std::vector<Source>& row, DepthImage& to) {
  for (int x = 0; x < from.width(); ++x) {
    const Source& source = row[static_cast<std::size_t>(x)];
    const float* meters = nearest(from, source);
    to.at(x, y) = meters ? source.depth_factor * *meters : 0.0F;
  }
}

/// `mask` may be empty.
void resample_mask(const GrayImage& mask, int y, const std::vector<Source>& row, GrayImage& to) {
  for (int x = 0; x < to.width(); ++x) {
    const Source& source = row[static_cast<std::size_t>(x)];
    const std::uint8_t* allowed = mask.empty() ? nullptr : nearest(mask, source);
    to.at(x, y) = allowed ? *allowed : mask.empty() && nearest(to, source) ? 255 : 0;
  }
}

bool has_size(int width, int height, const Camera& camera) { return width == camera.width && height == camera.height; }

}  // namespace

Frame by_global_shutter(Frame frame, const Camera& camera, const Eigen::Vector3d& camera_rotation) {
  constexpr double least_px = 0.5;
  const double most_px = 0.5 * camera.readout_s * camera_rotation.norm() * camera.fx;  // first and last row
  if (!(most_px >= least_px) || camera.height < 2 || camera.width < 2) return frame;
  if (!has_size(frame.image.width(), frame.image.height(), camera)) return frame;
  Frame result = frame;
  const bool color = has_size(frame.color.width(), frame.color.height(), camera),
             depth = has_size(frame.depth.width(), frame.depth.height(), camera);
  result.mask = GrayImage(camera.width, camera.height);
  RowShifts shifts(camera, camera_rotation);
  std::vector<Source> row(static_cast<std::size_t>(camera.width));
  for (int y = 0; y < camera.height; ++y) {
    shifts.sources(y, row);
    resample(frame.image, y, row, 1, result.image);
    if (color) resample(frame.color.rgb, y, row, 3, result.color.rgb);
    if (depth) resample_depth(frame.depth, y, row, result.depth);
    resample_mask(frame.mask, y, row, result.mask);
  }
  return result;
}

}  // namespace rastro
