// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/features/options.h"

#include "rastro/odometry/features/feature_source.h"

namespace rastro {
namespace {

void add_input_options(OptionTable& table, FeaturesOptions& o) {
  table.add({"matcher", &o.matcher, "",
             "how features are matched: tracks (occlusion-robust tracks, the fastest) or descriptors", 0, 0,
             matcher_names()});
  table.add({"features", &o.features, "", "number of features that tracks keeps in a frame", 20, 5000, {}});
  table.add({"min_distance_px", &o.min_distance_px, "px", "minimum distance between features of tracks", 1, 500, {}});
  table.add({"max_keypoints", &o.max_keypoints, "", "number of keypoints described in a frame", 20, 20000, {}});
  table.add({"max_ratio",
             &o.max_ratio,
             "",
             "ratio test: nearest descriptor distance / second nearest, at most (Lowe 2004)",
             0.1,
             1,
             {}});
  table.add({"seed", &o.seed, "", "seed of the random numbers", 0, 1e18, {}});
}

void add_start_options(OptionTable& table, FeaturesOptions& o) {
  table.add({"min_start_parallax_deg",
             &o.min_start_parallax_deg,
             "deg",
             "median parallax angle of the points that the first pair of frames needs; a smaller one makes their depth "
             "unreliable",
             0.05,
             20,
             {}});
  table.add({"min_start_points", &o.min_start_points, "", "matches that the first pair of frames needs", 8, 5000, {}});
  table.add({"min_start_inlier_share",
             &o.min_start_inlier_share,
             "",
             "share of these that must be inliers of the essential matrix",
             0.1,
             1,
             {}});
  table.add({"min_motion_px",
             &o.min_motion_px,
             "px",
             "below this median motion of the features the camera is at rest",
             0,
             10,
             {}});
}

void add_follow_options(OptionTable& table, FeaturesOptions& o) {
  table.add({"max_error_px", &o.max_error_px, "px", "maximum reprojection error of an inlier", 0.1, 50, {}});
  table.add({"min_points", &o.min_points, "", "inliers that a pose needs", 4, 1000, {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "RANSAC iterations, at most", 1, 100000, {}});
  table.add({"keyframe_parallax_px",
             &o.keyframe_parallax_px,
             "px",
             "a keyframe is added at this median motion of the features since the last one, rotation removed",
             0.1,
             500,
             {}});
  table.add({"min_keyframe_share",
             &o.min_keyframe_share,
             "",
             "a frame is a keyframe if a smaller share of its features has a map point",
             0,
             1,
             {}});
  table.add({"min_point_parallax_deg",
             &o.min_point_parallax_deg,
             "deg",
             "minimum angle between two rays to triangulate a point",
             0.01,
             20,
             {}});
  table.add({"max_point_error_px",
             &o.max_point_error_px,
             "px",
             "a map point with a larger reprojection error in any keyframe of the window is dropped",
             0.1,
             50,
             {}});
}

void add_refinement_options(OptionTable& table, FeaturesOptions& o) {
  table.add({"refine", &o.refine, "", "bundle adjustment of the last keyframes after each new one", 0, 1, {}});
  table.add({"window_keyframes", &o.window_keyframes, "", "keyframes of the bundle adjustment", 3, 100, {}});
  table.add({"refine_iterations", &o.refine_iterations, "", "Levenberg-Marquardt iterations, at most", 1, 100, {}});
  table.add({"huber_px", &o.huber_px, "px", "Huber kernel: larger errors count linearly", 0.1, 50, {}});
  table.add({"calibration_tolerance",
             &o.calibration_tolerance,
             "",
             "share of the focal length by which refinement may correct the calibration before frames report "
             "calibration_doubtful; right calibrations were corrected by up to 0.04, those wrong by 10 % by at least "
             "0.055; 0: no "
             "check",
             0,
             1,
             {}});
}

}  // namespace

OptionTable option_table(FeaturesOptions& options) {
  OptionTable table;
  add_input_options(table, options);
  add_start_options(table, options);
  add_follow_options(table, options);
  add_refinement_options(table, options);
  return table;
}

}  // namespace rastro
