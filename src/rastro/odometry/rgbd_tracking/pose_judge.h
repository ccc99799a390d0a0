// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/odometry/rgbd_tracking/options.h"
#include "rastro/odometry/rgbd_tracking/point_map.h"
#include "rastro/odometry/rgbd_tracking/pose_solver.h"
#include "rastro/odometry/rgbd_tracking/rgbd_follower.h"
#include "rastro/odometry/rgbd_tracking/surface_matcher.h"

namespace rastro {

/// Says whether features or surfaces determine a pose, and how certain it is.
class PoseJudge {
 public:
  PoseJudge(const RgbdOptions& options, double focal_px) : options_(options), focal_px_(focal_px) {}

  /// Whether features alone determine the pose: enough of them, in a third of the image.
  bool features_fit(const RgbdFollow& result) const;

  /// How much larger the squared errors of the features are than their noise: by motion blur, a rolling shutter,
  /// surfaces that say otherwise, or people. 1 where there are too few to say.
  struct ExcessVariance {
    double of_features = 1.0;  ///< At the pose of the features alone, with the larger noise of those that drift.
    double of_all = 1.0;       ///< At the pose of features and surfaces.
    double learned = 1.0;      ///< The part of both that the features' weights take account of, see FeatureNoise.
  };
  /// `measured`: all features, before outliers are taken out. `noise_factor`: of FeatureNoise, which their sigmas have.
  ExcessVariance excess_variance(const std::vector<PointMeasurement>& measured, const PoseSolution& solution,
                                 double noise_factor) const;

  /// Fills pose, covariance, state and reason; false: lost. `newest`: the last reference frame.
  bool judge(const PoseSolution& solution, const SurfaceMatch& match, const Reference& newest,
             const ExcessVariance& excess, RgbdFollow& result) const;

 private:
  void grade(double sigma, double excess, RgbdFollow& result) const;

  const RgbdOptions& options_;
  double focal_px_;
};

}  // namespace rastro
