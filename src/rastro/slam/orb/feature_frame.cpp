// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/feature_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rastro {
namespace {

constexpr float cell_px = 16.0F;
constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

int cell_of(float value, float least, int count) {
  return std::clamp(static_cast<int>(std::floor((value - least) / cell_px)), 0, count - 1);
}

}  // namespace

FeatureFrame::FeatureFrame(std::shared_ptr<const ImageFeatures> data, const Camera& camera, double baseline)
    : data_(std::move(data)), fx_(camera.fx), fy_(camera.fy), cx_(camera.cx), cy_(camera.cy), baseline_(baseline) {
  const auto& keypoints = data_->features.keypoints;
  pixels_.reserve(keypoints.size());
  right_.assign(keypoints.size(), unknown);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const auto ray = camera.unproject(Eigen::Vector2d(keypoints[i].x, keypoints[i].y));
    if (!ray) {
      pixels_.emplace_back(unknown, unknown);
      continue;
    }
    pixels_.emplace_back(static_cast<float>(fx_ * ray->x() + cx_), static_cast<float>(fy_ * ray->y() + cy_));
    if (i < data_->depths.size() && data_->depths[i] > 0.0F && baseline_ > 0.0)
      right_[i] = static_cast<float>(fx_ * (ray->x() - baseline_ / static_cast<double>(data_->depths[i])) + cx_);
  }
  build_grid(camera);
}

std::shared_ptr<const FeatureFrame> FeatureFrame::with_id(std::int64_t id) const {
  auto keyframe = std::make_shared<ImageFeatures>(*data_);
  keyframe->id = id;
  auto copy = std::make_shared<FeatureFrame>(*this);
  copy->data_ = std::move(keyframe);
  return copy;
}

void FeatureFrame::build_grid(const Camera& camera) {
  min_x_ = min_y_ = std::numeric_limits<float>::max();
  max_x_ = max_y_ = std::numeric_limits<float>::lowest();
  const auto include = [&](float x, float y) {
    min_x_ = std::min(min_x_, x);
    max_x_ = std::max(max_x_, x);
    min_y_ = std::min(min_y_, y);
    max_y_ = std::max(max_y_, y);
  };
  for (const Eigen::Vector2f& pixel : pixels_) {
    if (pixel.allFinite()) include(pixel.x(), pixel.y());
  }
  if (camera.distortion == Distortion::none && camera.width > 0) {
    include(0.0F, 0.0F);
    include(static_cast<float>(camera.width), static_cast<float>(camera.height));
  }
  if (max_x_ < min_x_) min_x_ = min_y_ = max_x_ = max_y_ = 0.0F;
  max_x_ += 1.0F;
  max_y_ += 1.0F;
  columns_ = std::clamp(static_cast<int>((max_x_ - min_x_) / cell_px) + 1, 1, 1000);
  rows_ = std::clamp(static_cast<int>((max_y_ - min_y_) / cell_px) + 1, 1, 1000);
  std::vector<std::uint32_t> cells(pixels_.size());
  cell_begin_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    if (!pixels_[i].allFinite()) continue;
    cells[i] = static_cast<std::uint32_t>(cell_of(pixels_[i].y(), min_y_, rows_) * columns_ +
                                          cell_of(pixels_[i].x(), min_x_, columns_));
    ++cell_begin_[cells[i] + 1];
  }
  for (std::size_t c = 1; c < cell_begin_.size(); ++c) cell_begin_[c] += cell_begin_[c - 1];
  cell_features_.resize(cell_begin_.back());
  std::vector<std::uint32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    if (pixels_[i].allFinite()) cell_features_[next[cells[i]]++] = static_cast<std::uint32_t>(i);
  }
}

Eigen::Vector2d FeatureFrame::ray(std::size_t feature) const {
  return {(static_cast<double>(pixels_[feature].x()) - cx_) / fx_,
          (static_cast<double>(pixels_[feature].y()) - cy_) / fy_};
}

double FeatureFrame::right_ray(std::size_t feature) const { return (static_cast<double>(right_[feature]) - cx_) / fx_; }

Eigen::Vector3d FeatureFrame::point(std::size_t feature) const {
  const double depth = data_->depths[feature];
  const Eigen::Vector2d direction = ray(feature);
  return {direction.x() * depth, direction.y() * depth, depth};
}

void FeatureFrame::find(float x, float y, float radius, int least, int most, std::vector<std::uint32_t>& found) const {
  found.clear();
  if (!(x + radius >= min_x_ && x - radius < max_x_ && y + radius >= min_y_ && y - radius < max_y_)) return;
  const int left = cell_of(x - radius, min_x_, columns_), right = cell_of(x + radius, min_x_, columns_);
  const int top = cell_of(y - radius, min_y_, rows_), bottom = cell_of(y + radius, min_y_, rows_);
  for (int row = top; row <= bottom; ++row) {
    // The cells of a row stand one after the other.
    const std::uint32_t begin = cell_begin_[static_cast<std::size_t>(row * columns_ + left)];
    const std::uint32_t end = cell_begin_[static_cast<std::size_t>(row * columns_ + right) + 1];
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t i = cell_features_[k];
      const int at = data_->features.levels[i];
      if (at < least || at > most) continue;
      if (std::abs(pixels_[i].x() - x) <= radius && std::abs(pixels_[i].y() - y) <= radius) found.push_back(i);
    }
  }
}

}  // namespace rastro
