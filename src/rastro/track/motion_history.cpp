// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/motion_history.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "rastro/base/random.h"
#include "rastro/math/median.h"
#include "rastro/multiview/homography.h"

namespace rastro {
namespace {

/// Features of a layer observed in both frames.
PointPairs pairs_since(std::int64_t frame, int layer, std::span<const Association> followed, const TrackStore& store) {
  PointPairs pairs;
  for (const Association& feature : followed) {
    const Track& track = store[feature.track];
    if (track.layer == layer && track.seen_in(frame)) pairs.add(track.undistorted_in(frame), feature.ideal);
  }
  return pairs;
}

using Step = MotionHistory::Step;

/// The motion with the most inliers, and the one with the most inliers among the rest, if there are enough.
std::vector<Step> steps_to(std::int64_t current, std::span<const Association> followed, const TrackStore& store,
                           const TrackOptions& options) {
  std::vector<Step> steps;
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < followed.size(); ++i) {
    if (store[followed[i].track].seen_in(current - 1)) left.push_back(i);
  }
  const auto seed = seed_for(options.seed ^ 0x6d6f74696f6eULL, static_cast<std::uint64_t>(current));
  const float limit = static_cast<float>(options.max_reprojection_px * options.max_reprojection_px);
  for (int layer = 0; layer < MotionHistory::layers && static_cast<int>(left.size()) >= options.min_inliers; ++layer) {
    PointPairs pairs;
    for (const std::size_t i : left) {
      pairs.add(store[followed[i].track].undistorted_in(current - 1), followed[i].ideal);
    }
    const auto fit = estimate_homography(pairs, {options.max_reprojection_px, 0.99, options.ransac_iterations,
                                                 seed_for(seed, static_cast<std::uint64_t>(layer))});
    if (!fit || fit->inliers < options.min_inliers) break;
    Step step{fit->model, std::vector<char>(followed.size(), 0)};
    std::vector<std::size_t> others;
    for (std::size_t k = 0; k < left.size(); ++k) {
      if (fit->squared_errors[k] <= limit) {
        step.takes_part[left[k]] = 1;
      } else {
        others.push_back(left[k]);
      }
    }
    steps.push_back(std::move(step));
    left = std::move(others);
  }
  return steps;
}

/// Keeps in each step only the features that fit no other step: those of both do not discriminate.
void keep_exclusive(std::vector<Step>& steps, std::int64_t current, std::span<const Association> followed,
                    const TrackStore& store, double max_error) {
  if (steps.size() < 2) return;
  for (std::size_t i = 0; i < followed.size(); ++i) {
    const Track& track = store[followed[i].track];
    if (!track.seen_in(current - 1)) continue;
    const auto fits = [&](const Step& step) {
      const auto there = transfer(step.current_from_last, track.undistorted_in(current - 1).cast<double>());
      return there && (*there - followed[i].ideal.cast<double>()).norm() <= max_error;
    };
    if (steps[0].takes_part[i] != 0 && fits(steps[1])) steps[0].takes_part[i] = 0;
  }
}

/// Number of a layer's features in a step.
int members(const Step& step, int layer, std::span<const Association> followed, const TrackStore& store) {
  int count = 0;
  for (std::size_t i = 0; i < followed.size(); ++i) {
    count += step.takes_part[i] != 0 && store[followed[i].track].layer == layer ? 1 : 0;
  }
  return count;
}

}  // namespace

// Patches are kept for up to two intervals before a feature is lost.
MotionHistory::MotionHistory(const TrackOptions& options) : options_(options) {
  for (auto& motions : motions_)
    motions.resize(static_cast<std::size_t>(options.window + 2 * options.reference_interval + 2));
}

int MotionHistory::layer_of_first(const std::vector<Step>& steps, std::span<const Association> followed,
                                  const TrackStore& store) {
  int straight = members(steps[0], 0, followed, store), crossed = members(steps[0], 1, followed, store);
  if (steps.size() > 1) {
    straight += members(steps[1], 1, followed, store);
    crossed += members(steps[1], 0, followed, store);
  }
  return crossed > straight ? 1 : 0;
}

/// Motion of a layer without a step of its own: the median of its few features; its previous motion, if the layers had
/// different motions; else that of the other layer.
Eigen::Matrix3d MotionHistory::guess_step(int layer, const Step& other, std::int64_t current,
                                          std::span<const Association> followed, const TrackStore& store) const {
  constexpr std::size_t fewest = 3;
  std::vector<float> dx, dy;
  for (std::size_t i = 0; i < followed.size(); ++i) {
    const Track& track = store[followed[i].track];
    if (track.layer != layer || other.takes_part[i] != 0 || !track.seen_in(current - 1)) continue;
    dx.push_back(followed[i].ideal.x() - track.undistorted_in(current - 1).x());
    dy.push_back(followed[i].ideal.y() - track.undistorted_in(current - 1).y());
  }
  if (!layers_differ_) return other.current_from_last;
  if (dx.size() < fewest) return last_step_[static_cast<std::size_t>(layer)];
  Eigen::Matrix3d step = Eigen::Matrix3d::Identity();
  step(0, 2) = static_cast<double>(upper_median(std::move(dx)));
  step(1, 2) = static_cast<double>(upper_median(std::move(dy)));
  return step;
}

void MotionHistory::advance(std::int64_t current, std::span<const Association> followed, TrackStore& store) {
  current_ = current;
  std::vector<Step> steps = steps_to(current, followed, store, options_);
  keep_exclusive(steps, current, followed, store, options_.max_reprojection_px);
  if (steps.empty()) {
    for (auto& motions : motions_) {
      for (Motion& motion : motions) motion.frame = -1;
    }
    layers_differ_ = false;
  } else {
    const int first = layer_of_first(steps, followed, store);
    if (steps.size() == 1 && members(steps[0], 1 - first, followed, store) > 0) layers_differ_ = false;
    if (steps.size() > 1) layers_differ_ = true;
    const Eigen::Matrix3d other =
        steps.size() > 1 ? steps[1].current_from_last : guess_step(1 - first, steps[0], current, followed, store);
    move(first, steps[0].current_from_last);
    move(1 - first, other);
    for (std::size_t i = 0; i < followed.size(); ++i) {
      for (std::size_t k = 0; k < steps.size(); ++k) {
        if (steps[k].takes_part[i] != 0) store[followed[i].track].layer = k == 0 ? first : 1 - first;
      }
    }
  }
  for (int layer = 0; layer < layers; ++layer) {
    Motion& none = at(current, layer);
    none.frame = current;
    none.current_from_frame.setIdentity();
  }
}

void MotionHistory::move(int layer, const Eigen::Matrix3d& step) {
  last_step_[static_cast<std::size_t>(layer)] = step;
  for (Motion& motion : motions_[static_cast<std::size_t>(layer)]) {
    if (motion.frame < 0) continue;
    motion.current_from_frame = step * motion.current_from_frame;
    motion.current_from_frame /= motion.current_from_frame.norm();
  }
}

const MotionHistory::Motion* MotionHistory::since(std::int64_t frame, int layer, std::span<const Association> followed,
                                                  const TrackStore& store) {
  if (frame < 0) return nullptr;
  Motion& motion = at(frame, layer);
  if (motion.frame != frame) return nullptr;
  if (motion.refined_in != current_) refine(motion, layer, followed, store);
  return &motion;
}

std::optional<Eigen::Matrix2f> MotionHistory::rotated_since(std::int64_t frame, int layer, const Track& track,
                                                            std::span<const Association> followed,
                                                            const TrackStore& store) {
  const Motion* motion = since(frame, layer, followed, store);
  if (!motion || !track.seen_in(frame)) return std::nullopt;
  return derivative_at(motion->current_from_frame, track.undistorted_in(frame));
}

void MotionHistory::refine(Motion& motion, int layer, std::span<const Association> followed,
                           const TrackStore& store) const {
  motion.refined_in = current_;
  motion.inlier_share = 0.0;
  motion.shared = pairs_since(motion.frame, layer, followed, store);
  // The chain drifts, so the inlier threshold is wider at first.
  for (const double limit : {3.0 * options_.max_reprojection_px, options_.max_reprojection_px}) {
    const auto fit = refine_homography(motion.shared, motion.current_from_frame, limit);
    if (!fit || fit->inliers < options_.min_inliers) return;
    motion.current_from_frame = fit->model / fit->model.norm();
    motion.inlier_share = static_cast<double>(fit->inliers) / static_cast<double>(motion.shared.size());
  }
}

std::optional<Eigen::Vector2d> moved_pixel(const Eigen::Matrix3d& homography, const Eigen::Vector2f& ideal,
                                           const UndistortedCamera& camera) {
  const auto there = transfer(homography, ideal.cast<double>());
  return there ? camera.to_pixel(*there) : std::nullopt;
}

std::optional<Eigen::Matrix2f> derivative_at(const Eigen::Matrix3d& homography, const Eigen::Vector2f& ideal) {
  const Eigen::Vector3d image = homography * ideal.cast<double>().homogeneous();
  if (std::abs(image.z()) < 1e-12) return std::nullopt;
  const Eigen::Vector2d to = image.head<2>() / image.z();
  const Eigen::Matrix2d derivative = (homography.topLeftCorner<2, 2>() - to * homography.block<1, 2>(2, 0)) / image.z();
  constexpr double most = 2.0;
  const double area = derivative.determinant(), squares = derivative.squaredNorm();
  // The singular values s, t have s t = area and s^2 + t^2 = squares.
  if (!(area > 0.0)) return std::nullopt;
  const double larger = std::sqrt(0.5 * (squares + std::sqrt(std::max(0.0, squares * squares - 4.0 * area * area))));
  if (larger > most || area / larger < 1.0 / most) return std::nullopt;
  return Eigen::Matrix2f(derivative.cast<float>());
}

}  // namespace rastro
