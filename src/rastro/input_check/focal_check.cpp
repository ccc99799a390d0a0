// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/focal_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/input_check/depth_focal.h"
#include "rastro/input_check/motion_residual.h"
#include "rastro/input_check/window_bundle.h"
#include "rastro/math/median.h"

namespace rastro {
namespace {

// By bundle adjustment: a correction of the focal length below least_correction is no error of the calibration.
constexpr double least_correction = 0.2, sure = 4.0;
constexpr int least_adjusted = 3;
// By depth: what a window may be off for reasons that its residuals do not show, such as depth of another camera.
// Features err alike in groups, so that a sigma by their scatter is too small.
constexpr double least_difference = 0.1, unseen_sigma = 0.03, sigma_factor = 2.0;
constexpr int least_with_depth = 3;
constexpr std::size_t given_factor = 2;
constexpr double clearly_better = 0.8, clear_px = 0.15;
constexpr double worst_px = 4.0;  // Larger residuals say no more.
// Evidence is the logarithm of the ratio of residuals: two windows where another focal length leaves 0.6 of them.
constexpr int least_votes = 2;
constexpr double least_evidence = 1.0;

struct Votes {
  std::vector<double> given, better;
  double evidence = 0.0;
  void add(double given_px, double better_px) {
    given.push_back(given_px);
    better.push_back(better_px);
    evidence += std::log(given_px / better_px);
  }
};

Camera with_focal_factor(Camera camera, double factor) {
  camera.fx *= factor;
  camera.fy *= factor;
  return camera;
}

}  // namespace

FocalCheck::FocalCheck(const std::optional<Camera>& camera) : camera_(camera), adjustment_(least_correction) {}

std::optional<FocalCheck::Residuals> FocalCheck::residuals_of(const TrackedWindow& window) const {
  Residuals residuals{};
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const auto residual = motion_residual(window, with_focal_factor(*camera_, factors[k]));
    residuals[k] = residual.value_or(std::numeric_limits<double>::infinity());
  }
  const double best = *std::min_element(residuals.begin(), residuals.end());
  if (!std::isfinite(best)) return std::nullopt;
  return residuals;
}

void FocalCheck::add(const TrackedWindow& window, bool trusts_depth, InputWarnings& found) {
  if (!camera_ || said_) return;
  if (trusts_depth) compare_with_depth(window, found);
  if (said_) return;
  adjust(window, found);
  if (said_) return;
  const auto residuals = residuals_of(window);
  if (!residuals) return;
  windows_.push_back(*residuals);
  judge(found);
}

void FocalCheck::compare_with_depth(const TrackedWindow& window, InputWarnings& found) {
  const auto fit = focal_from_depth(window, *camera_);
  if (!fit) return;
  by_depth_.add(*fit);
  const FocalFit mean = by_depth_.mean();
  const double limit = std::max(least_difference, sure * mean.sigma);
  if (by_depth_.windows < least_with_depth || !(std::abs(mean.log_factor) >= limit)) return;
  said_ = true;
  const double focal_px = camera_->fx * std::exp(mean.log_factor);
  found.push_back({"focal_length",
                   fmt::format("features and depth move as with a {} focal length: {:.0f} +- {:.0f} px by {} windows, "
                               "the calibration has fx = {:.0f} px; check fx, fy and the image size of the calibration",
                               mean.log_factor < 0.0 ? "shorter" : "longer", focal_px, mean.sigma * focal_px,
                               by_depth_.windows, camera_->fx)});
}

void FocalCheck::ByDepth::add(const FocalFit& fit) {
  const double sigma = std::hypot(sigma_factor * fit.sigma, unseen_sigma), weight = 1.0 / (sigma * sigma);
  ++windows;
  weights += weight;
  sum += weight * fit.log_factor;
  squares += weight * fit.log_factor * fit.log_factor;
}

FocalFit FocalCheck::ByDepth::mean() const {
  const double mean = sum / weights, scatter = (squares - sum * mean) / std::max(1, windows - 1);
  return {mean, std::sqrt(std::max(1.0, scatter) / weights)};
}

void FocalCheck::adjust(const TrackedWindow& window, InputWarnings& found) {
  const auto bundle = adjusted_bundle(window, *camera_);
  if (!bundle) return;
  adjustment_.add(*bundle);
  const auto [scale, sigma] = adjustment_.scale();
  if (adjustment_.windows() < least_adjusted || std::abs(scale) < std::max(least_correction, sure * sigma)) return;
  said_ = true;
  found.push_back(
      {"focal_length",
       fmt::format("features move as with a {} focal length: bundle adjustment of {} windows makes it {:.2f} "
                   "+- {:.2f} times as long as fx = {:.0f} px; check fx, fy and the image size of the "
                   "calibration",
                   scale > 0.0 ? "shorter" : "longer", adjustment_.windows(), 1.0 / (1.0 + scale),
                   sigma / ((1.0 + scale) * (1.0 + scale)), camera_->fx)});
}

void FocalCheck::judge(InputWarnings& found) {
  Votes shorter, longer;
  int right = 0;
  for (const Residuals& each : windows_) {
    const auto best = static_cast<std::size_t>(std::min_element(each.begin(), each.end()) - each.begin());
    const double given = each[given_factor], worst = std::min(worst_px, *std::max_element(each.begin(), each.end()));
    if (best == given_factor) {
      right += each[best] < clearly_better * worst ? 1 : 0;
    } else if (each[best] < clearly_better * given && given - each[best] > clear_px) {
      (best < given_factor ? shorter : longer).add(std::min(given, worst_px), each[best]);
    }
  }
  const bool is_shorter = shorter.given.size() > longer.given.size();
  const Votes& votes = is_shorter ? shorter : longer;
  const auto against = static_cast<int>(votes.given.size()),
             others = right + static_cast<int>((is_shorter ? longer : shorter).given.size());
  if (against < least_votes || votes.evidence < least_evidence || against < 3 * others) return;
  said_ = true;
  found.push_back(
      {"focal_length",
       fmt::format("features move as with a {} focal length: residual {:.2f} px with fx = {:.0f} px, "
                   "{:.2f} px with {} of it (medians of {} windows); check fx, fy and the image size of the "
                   "calibration",
                   is_shorter ? "shorter" : "longer", median(votes.given), camera_->fx, median(votes.better),
                   is_shorter ? "0.5 to 0.7" : "1.4 to 2", against)});
}

}  // namespace rastro
