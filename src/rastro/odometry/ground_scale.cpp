// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/ground_scale.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

// The area of the road compared, in camera heights: to both sides and ahead.
constexpr double widest = 1.5, nearest = 3.2, farthest = 9.0;
constexpr int sample_step_px = 3;
// A pixel without texture costs time and has no information.
constexpr int least_gradient = 8;
constexpr std::size_t most_samples = 400;
constexpr std::size_t fewest_samples = 100;
// Height hypotheses, in the unit of the motion: the path length of the step times these.
constexpr double lowest = 0.02, highest = 400.0;
constexpr int heights = 400;
// The road is parallel to the direction of travel, which over so many steps is well known.
constexpr double direction_memory = 0.1;
constexpr double largest_pitch = 0.2;
constexpr float largest_difference = 20.0F;
constexpr float not_seen = -1.0F;
constexpr double nearest_depth = 0.1;
// A longer step, in camera heights, leaves the road behind.
constexpr double longest_step = 2.0;
// The image to compare with stays until the camera has moved by this share of its usual step: the direction of less is
// noise.
constexpr double least_share = 0.3;
constexpr double step_memory = 0.1;
constexpr int fewest_frames = 10;

double height_at(double index) { return lowest * std::pow(highest / lowest, index / (heights - 1)); }
Eigen::Vector3d downwards(double pitch) { return {0.0, std::cos(pitch), std::sin(pitch)}; }

std::optional<float> gray_at(GrayView image, const Eigen::Vector2d& pixel) {
  const double x = std::floor(pixel.x()), y = std::floor(pixel.y());
  if (!(x >= 0.0 && y >= 0.0 && x < image.width - 1 && y < image.height - 1)) return std::nullopt;
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const float fx = static_cast<float>(pixel.x() - x), fy = static_cast<float>(pixel.y() - y);
  const float upper = static_cast<float>(image.at(ix, iy)) * (1 - fx) + static_cast<float>(image.at(ix + 1, iy)) * fx;
  const float lower =
      static_cast<float>(image.at(ix, iy + 1)) * (1 - fx) + static_cast<float>(image.at(ix + 1, iy + 1)) * fx;
  return upper * (1 - fy) + lower * fy;
}

}  // namespace

void GroundScale::choose_samples(GrayView image) {
  samples_.clear();
  const Eigen::Vector3d down = downwards(0.0);
  for (int y = 0; y < image.height; y += sample_step_px) {
    for (int x = 0; x < image.width; x += sample_step_px) {
      const auto ray = camera_.unproject({static_cast<double>(x), static_cast<double>(y)});
      if (!ray) continue;
      const double slope = down.dot(ray->homogeneous());
      if (slope * farthest < 1.0 || slope * nearest > 1.0 || std::abs(ray->x()) > widest * slope) continue;
      samples_.push_back({*ray, x, y, 0.0F});
    }
  }
}

void GroundScale::add(GrayView image, const SE3& world_from_camera) {
  if (image.empty()) return;
  if (width_ != image.width || height_ != image.height) choose_samples(image);
  const bool comparable = last_pose_ && width_ == image.width && height_ == image.height;
  if (comparable) {
    const SE3 current_from_last = world_from_camera.inverse() * *last_pose_;
    const double step = current_from_last.translation().norm();
    if (step < least_share * usual_step_) return;
    usual_step_ = usual_step_ > 0.0 ? (1.0 - step_memory) * usual_step_ + step_memory * step : step;
    if (const auto costs = compare(image, current_from_last)) (even_.frames == odd_.frames ? even_ : odd_).add(*costs);
  }
  last_pose_ = world_from_camera;
  width_ = image.width;
  height_ = image.height;
  keep_textured(image);
}

/// The road's pixels with texture, evenly thinned out where there are many.
void GroundScale::keep_textured(GrayView image) {
  std::vector<Sample> textured;
  for (const Sample& sample : samples_) {
    if (sample.x < 1 || sample.y < 1 || sample.x + 1 >= image.width || sample.y + 1 >= image.height) continue;
    const int across = image.at(sample.x + 1, sample.y) - image.at(sample.x - 1, sample.y);
    const int down = image.at(sample.x, sample.y + 1) - image.at(sample.x, sample.y - 1);
    if (std::abs(across) + std::abs(down) < least_gradient) continue;
    textured.push_back(sample);
    textured.back().gray = static_cast<float>(image.at(sample.x, sample.y));
  }
  textured_.clear();
  const std::size_t stride = 1 + textured.size() / most_samples;
  for (std::size_t i = 0; i < textured.size(); i += stride) textured_.push_back(textured[i]);
}

std::optional<GroundScale::Costs> GroundScale::compare(GrayView image, const SE3& current_from_last) {
  const double step = current_from_last.translation().norm();
  if (textured_.size() < fewest_samples || step < 1e-9) return std::nullopt;
  const Eigen::Vector3d moved = current_from_last.inverse().translation() / step;
  const Eigen::Vector3d ahead = moved.z() < 0.0 ? Eigen::Vector3d(-moved) : moved;  // a car may drive backward
  direction_ =
      direction_.isZero() ? ahead : Eigen::Vector3d((1.0 - direction_memory) * direction_ + direction_memory * ahead);
  pitch_rad_ = std::clamp(-std::atan2(direction_.y(), direction_.z()), -largest_pitch, largest_pitch);
  const Eigen::Vector3d down = downwards(pitch_rad_);
  std::vector<Eigen::Vector3d> rotated(textured_.size());
  const Eigen::Matrix3d rotation = current_from_last.rotation().matrix();
  for (std::size_t i = 0; i < textured_.size(); ++i) {
    const Eigen::Vector3d ray = textured_[i].ray.homogeneous();
    rotated[i] = rotation * (ray / down.dot(ray));
  }
  Costs costs(static_cast<std::size_t>(heights), not_seen);
  for (int h = 0; h < heights; ++h) {
    const double height = height_at(h);
    if (step > longest_step * height) continue;
    costs[static_cast<std::size_t>(h)] = difference(image, rotated, current_from_last.translation() / height);
  }
  return costs;
}

/// Mean intensity difference at the predicted positions of the road's samples; not_seen if most of them left the image.
float GroundScale::difference(GrayView image, const std::vector<Eigen::Vector3d>& rotated,
                              const Eigen::Vector3d& moved) const {
  const bool plain = camera_.distortion == Distortion::none;
  float sum = 0.0F;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < rotated.size(); ++i) {
    const Eigen::Vector3d there = rotated[i] + moved;
    if (there.z() < nearest_depth) continue;
    std::optional<Eigen::Vector2d> pixel;
    if (plain) {
      const double inverse = 1.0 / there.z();
      pixel =
          Eigen::Vector2d(camera_.fx * there.x() * inverse + camera_.cx, camera_.fy * there.y() * inverse + camera_.cy);
    } else {
      pixel = camera_.project(there);
    }
    const auto gray = pixel ? gray_at(image, *pixel) : std::nullopt;
    if (!gray) continue;
    sum += std::min(largest_difference, std::abs(*gray - textured_[i].gray));
    ++seen;
  }
  return 2 * seen > rotated.size() ? sum / static_cast<float>(seen) : not_seen;
}

void GroundScale::Sums::add(const Costs& costs) {
  total.resize(costs.size(), 0.0);
  votes.resize(costs.size(), 0);
  ++frames;
  const float worst = *std::max_element(costs.begin(), costs.end());
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (costs[i] == not_seen) continue;
    total[i] += static_cast<double>(costs[i] / std::max(1.0F, worst));
    ++votes[i];
  }
}

void GroundScale::Sums::add(const Sums& other) {
  total.resize(std::max(total.size(), other.total.size()), 0.0);
  votes.resize(total.size(), 0);
  frames += other.frames;
  for (std::size_t i = 0; i < other.total.size(); ++i) {
    total[i] += other.total[i];
    votes[i] += other.votes[i];
  }
}

/// The best height, as a fractional index.
std::optional<double> GroundScale::best_of(const Sums& sums) {
  const std::vector<double>& total = sums.total;
  const std::vector<int>& votes = sums.votes;
  std::optional<std::size_t> best;
  const auto mean = [&](std::size_t i) { return total[i] / votes[i]; };
  const auto is_known = [&](std::size_t i) { return votes[i] > 0 && 2 * votes[i] >= sums.frames; };
  for (std::size_t i = 0; i < total.size(); ++i) {
    if (is_known(i) && (!best || mean(i) < mean(*best))) best = i;
  }
  // At the end of what is known, the best height may lie beyond.
  if (!best || *best == 0 || *best + 1 == total.size() || !is_known(*best - 1) || !is_known(*best + 1))
    return std::nullopt;
  const double before = mean(*best - 1), here = mean(*best), after = mean(*best + 1);
  const double bend = before - 2.0 * here + after;
  return static_cast<double>(*best) + (bend > 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0);
}

std::optional<GroundScale::Found> GroundScale::find() const {
  Sums all = even_;
  all.add(odd_);
  if (all.frames < fewest_frames) return std::nullopt;
  const auto best = best_of(all);
  if (!best) return std::nullopt;
  Found found;
  found.meters_per_unit = camera_height_m_ / height_at(*best);
  found.pitch_rad = pitch_rad_;
  found.frames = all.frames;
  const auto even = best_of(even_), odd = best_of(odd_);
  found.relative_sigma = even && odd ? 0.5 * std::abs(std::log(height_at(*even) / height_at(*odd))) : 1.0;
  return found;
}

}  // namespace rastro
