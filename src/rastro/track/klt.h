// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/image/pyramid.h"

namespace rastro {

struct KltPatch;

constexpr int klt_largest_window = 31;
constexpr int klt_padding = 48;

struct KltOptions {
  int window_px = 21;               ///< Side of the square template; odd, 5..31.
  int iterations = 30;              ///< At most, per level.
  double epsilon_px = 0.01;         ///< A smaller step ends the finest level.
  double coarse_epsilon_px = 0.01;  ///< As `epsilon_px`, for the coarser levels, which the next one refines.
  int backward_levels = 1;          ///< Levels of backward tracking, starting from the old position; 0: no check.
  double max_backward_px = 0.5;     ///< Larger forward-backward error: lost.
  double min_eigenvalue = 1e-3;     ///< Minimum eigenvalue of the mean structure tensor, (intensity/px)^2: below: lost.
  double max_residual_ratio = 0.3;  ///< Squared residual as share of the template's variance; above: lost.
};

struct KltResult {
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  bool followed = false;
  float residual_ratio = 0.0F;
};

/// Pyramidal Lucas-Kanade optical flow (Bouguet 2000) from `previous` to `current`, with forward-backward check. It
/// also solves for the template's mean brightness change. `guesses` are initial positions in the current image. All
/// sums are integers, so every SIMD level and every pool gives the same bytes. Pyramids need padding >= klt_padding.
void klt_follow(const Pyramid& previous, const Pyramid& current, std::span<const Eigen::Vector2f> points,
                std::span<const Eigen::Vector2f> guesses, const KltOptions& options, TaskPool* pool,
                std::span<KltResult> results);

/// Template of a feature: the pixels around it at some time, kept for later comparison and alignment, also rotated and
/// scaled.
class KltReference {
 public:
  bool empty() const { return size_ == 0; }
  void clear() { size_ = 0; }
  /// Keeps the window around `point` of the finest level; unchanged if the point is too far outside.
  void keep(const Pyramid& pyramid, const Eigen::Vector2f& point, int window_px);

  /// Aligns the template with the current image, starting at `guess` (finest level only, so from a few pixels away).
  /// `followed` says whether the options' limits hold; there is no backward check. `current_from_reference`: rotation
  /// and scale of the surroundings since (the derivative of the motion).
  KltResult align(const Pyramid& current, const Eigen::Vector2f& guess, double reach_px, const KltOptions& options,
                  const Eigen::Matrix2f& current_from_reference = Eigen::Matrix2f::Identity()) const;
  /// Squared difference from the current image at `point`, as share of the template's variance (1e9 outside).
  double residual_ratio(const Pyramid& current, const Eigen::Vector2f& point,
                        const Eigen::Matrix2f& current_from_reference = Eigen::Matrix2f::Identity()) const;

 private:
  void cut(const Eigen::Matrix2f& current_from_reference, KltPatch& patch) const;
  /// Extra pixels kept on each side for rotated windows.
  int margin() const { return size_ / 4 + 2; }
  int stride() const { return size_ + 3 + 2 * margin(); }

  std::vector<std::uint8_t> pixels_;
  std::int16_t fraction_x_ = 0, fraction_y_ = 0;
  int size_ = 0;
};

}  // namespace rastro
