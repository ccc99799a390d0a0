// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/features/options.h"

#include "rastro/odometry/features/feature_source.h"

namespace rastro {
namespace {

void add_input_options(OptionTable& table, FeaturesOptions& o) {
  table.add({"matcher", &o.matcher, "",
             "what features are matched by: tracks (the occlusion-robust tracks, the fastest) or descriptors", 0, 0,
             matcher_names()});
  table.add({"features", &o.features, "", "features held in a frame by tracks", 20, 5000, {}});
  table.add({"min_distance_px", &o.min_distance_px, "px", "least distance between features of tracks", 1, 500, {}});
  table.add({"max_keypoints", &o.max_keypoints, "", "keypoints of a frame that get a descriptor", 20, 20000, {}});
  table.add({"max_ratio",
             &o.max_ratio,
             "",
             "a descriptor's nearest must be at most this share as far as its second nearest (Lowe 2004)",
             0.1,
             1,
             {}});
  table.add({"seed", &o.seed, "", "of every random draw", 0, 1e18, {}});
}

void add_start_options(OptionTable& table, FeaturesOptions& o) {
  table.add({"min_start_parallax_deg",
             &o.min_start_parallax_deg,
             "deg",
             "median angle between the two rays to a point that the first pair of frames must have: less makes depth a "
             "guess",
             0.05,
             20,
             {}});
  table.add({"min_start_points", &o.min_start_points, "", "points the first pair of frames must share", 8, 5000, {}});
  table.add({"min_start_inlier_share",
             &o.min_start_inlier_share,
             "",
             "share of these that one essential matrix must explain",
             0.1,
             1,
             {}});
  table.add({"min_motion_px",
             &o.min_motion_px,
             "px",
             "features that moved less than this in the median mean that the camera stood still",
             0,
             10,
             {}});
}

void add_follow_options(OptionTable& table, FeaturesOptions& o) {
  table.add({"max_error_px", &o.max_error_px, "px", "reprojection error of an inlier", 0.1, 50, {}});
  table.add({"min_points", &o.min_points, "", "inliers a pose must have", 4, 1000, {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "most samples drawn for one motion", 1, 100000, {}});
  table.add({"keyframe_parallax_px",
             &o.keyframe_parallax_px,
             "px",
             "median motion of the features since the last keyframe, turning taken out, that makes a new one",
             0.1,
             500,
             {}});
  table.add({"min_keyframe_share",
             &o.min_keyframe_share,
             "",
             "a frame in which fewer of the features have a point in space is a keyframe",
             0,
             1,
             {}});
  table.add({"min_point_parallax_deg",
             &o.min_point_parallax_deg,
             "deg",
             "angle between two rays to a point before it is placed in space",
             0.01,
             20,
             {}});
  table.add({"max_point_error_px",
             &o.max_point_error_px,
             "px",
             "a point in space seen farther off in any keyframe of the window is dropped",
             0.1,
             50,
             {}});
}

void add_refinement_options(OptionTable& table, FeaturesOptions& o) {
  table.add({"refine", &o.refine, "", "bundle adjustment of the last keyframes after each new one", 0, 1, {}});
  table.add({"window_keyframes", &o.window_keyframes, "", "keyframes adjusted together", 3, 100, {}});
  table.add({"refine_iterations", &o.refine_iterations, "", "Levenberg-Marquardt steps at most", 1, 100, {}});
  table.add({"huber_px", &o.huber_px, "px", "errors beyond count linearly", 0.1, 50, {}});
  table.add(
      {"calibration_tolerance",
       &o.calibration_tolerance,
       "",
       "share of the focal length by which the calibration may be off, as refinement shows it, before frames say "
       "calibration_doubtful; right calibrations came out up to 0.04 off, wrong ones by 10 % at least 0.055; 0: no "
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
