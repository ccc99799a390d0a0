// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/feature_frame.h"

#include <limits>
#include <utility>

namespace rastro {
namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

/// The keyframe's features, kept alive with it.
std::shared_ptr<const Features> features_of(const std::shared_ptr<const ImageFeatures>& data) {
  return {data, &data->features};
}

}  // namespace

FeatureFrame::FeatureFrame(std::shared_ptr<const ImageFeatures> data, const Camera& camera, double baseline)
    : data_(std::move(data)),
      fx_(camera.fx),
      fy_(camera.fy),
      cx_(camera.cx),
      cy_(camera.cy),
      grid_(make_grid(camera, baseline)) {}

FeatureGrid FeatureFrame::make_grid(const Camera& camera, double baseline) const {
  const auto& keypoints = data_->features.keypoints;
  std::vector<Eigen::Vector2f> pixels;
  pixels.reserve(keypoints.size());
  std::vector<float> right(keypoints.size(), unknown);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const auto ray = camera.unproject(Eigen::Vector2d(keypoints[i].x, keypoints[i].y));
    if (!ray) {
      pixels.emplace_back(unknown, unknown);
      continue;
    }
    pixels.emplace_back(static_cast<float>(fx_ * ray->x() + cx_), static_cast<float>(fy_ * ray->y() + cy_));
    if (i < data_->depths.size() && data_->depths[i] > 0.0F && baseline > 0.0)
      right[i] = static_cast<float>(fx_ * (ray->x() - baseline / static_cast<double>(data_->depths[i])) + cx_);
  }
  return {camera, features_of(data_), std::move(pixels), std::move(right)};
}

std::shared_ptr<const FeatureFrame> FeatureFrame::with_id(std::int64_t id) const {
  auto keyframe = std::make_shared<ImageFeatures>(*data_);
  keyframe->id = id;
  auto copy = std::make_shared<FeatureFrame>(*this);
  copy->data_ = std::move(keyframe);
  copy->grid_.share(features_of(copy->data_));
  return copy;
}

Eigen::Vector2d FeatureFrame::ray(std::size_t feature) const {
  const Eigen::Vector2f& at = pixel(feature);
  return {(static_cast<double>(at.x()) - cx_) / fx_, (static_cast<double>(at.y()) - cy_) / fy_};
}

double FeatureFrame::right_ray(std::size_t feature) const {
  return (static_cast<double>(right_pixel(feature)) - cx_) / fx_;
}

Eigen::Vector3d FeatureFrame::point(std::size_t feature) const {
  const double depth = data_->depths[feature];
  const Eigen::Vector2d direction = ray(feature);
  return {direction.x() * depth, direction.y() * depth, depth};
}

}  // namespace rastro
