// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "rastro/base/task_pool.h"
#include "rastro/image/pyramid.h"

namespace rastro {

constexpr int klt_largest_window = 31;

struct KltOptions {
  int window_px = 21;               ///< Side of the square patch; odd, 5..31.
  int iterations = 30;              ///< At most, per level.
  double epsilon_px = 0.01;         ///< A smaller step ends a level.
  int backward_levels = 2;          ///< Levels of the way back, starting from the old place; 0 leaves the check out.
  double max_backward_px = 0.5;     ///< Farther from the old place after going back: not followed.
  double min_eigenvalue = 1e-3;     ///< Of the patch's mean structure tensor, in (grey/px)^2: less texture cannot be followed.
  double max_residual_ratio = 1.0;  ///< Squared difference left over, as share of the patch's own variance; above: not followed.
};

struct KltResult {
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  bool followed = false;
  float residual_ratio = 0.0F;
};

/// Pyramidal Lucas-Kanade optical flow (Bouguet 2000) from `previous` to `current`, with forward-backward check and the patch's mean
/// brightness change solved along. `guesses` are first guesses in the current image. All sums are integers, so every SIMD level and
/// every pool gives the same bytes. Pyramids need padding >= klt_padding.
void klt_follow(const Pyramid& previous, const Pyramid& current, std::span<const Eigen::Vector2f> points,
                std::span<const Eigen::Vector2f> guesses, const KltOptions& options, TaskPool* pool, std::span<KltResult> results);

constexpr int klt_padding = 48;

}  // namespace rastro
