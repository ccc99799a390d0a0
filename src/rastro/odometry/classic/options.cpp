// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/classic/options.h"

namespace rastro {
namespace {

void add_feature_options(OptionTable& table, ClassicOptions& o) {
  table.add({"matcher",
             &o.matcher,
             "",
             "detector and descriptor; surf as in the paper, needs a build with RASTRO_WITH_SURF",
             0,
             0,
             {"surf", "sift", "orb"}});
  table.add({"max_keypoints", &o.max_keypoints, "", "number of keypoints described in a frame", 20, 20000, {}});
  table.add({"surf_threshold",
             &o.surf_threshold,
             "",
             "minimum determinant of the Hessian of a SURF keypoint, in dlib's unit",
             0,
             1e6,
             {}});
  table.add({"sift_contrast", &o.sift_contrast, "", "minimum contrast of a SIFT keypoint, in OpenCV's unit", 0, 1, {}});
  table.add({"orb_fast_threshold",
             &o.orb_fast_threshold,
             "intensity",
             "threshold of the corner test of an ORB keypoint",
             1,
             255,
             {}});
  table.add({"max_ratio",
             &o.max_ratio,
             "",
             "ratio test: nearest descriptor distance / second nearest, at most (Lowe 2004); the paper gives no value",
             0.1,
             1,
             {}});
  table.add({"mutual", &o.mutual, "", "matches must be each other's nearest", 0, 1, {}});
  table.add({"seed", &o.seed, "", "seed of the random numbers", 0, 9.0e15, {}});
}

void add_pair_options(OptionTable& table, ClassicOptions& o) {
  table.add({"max_epipolar_error_px",
             &o.max_epipolar_error_px,
             "px",
             "maximum Sampson distance of an inlier of the essential matrix",
             0.05,
             50,
             {}});
  table.add({"max_point_error_px",
             &o.max_point_error_px,
             "px",
             "maximum reprojection error in k-2 and k-1 of a point triangulated from them",
             0.1,
             100,
             {}});
  table.add({"min_point_parallax_deg",
             &o.min_point_parallax_deg,
             "deg",
             "minimum angle between two rays to triangulate a point; 0: any, as in the paper",
             0,
             45,
             {}});
  table.add({"min_parallax_deg",
             &o.min_parallax_deg,
             "deg",
             "median parallax that a pair of frames needs to be triangulated; a frame with less keeps k-2 and k-1. 0: "
             "every frame moves on, as in the paper",
             0,
             20,
             {}});
  table.add({"min_motion_px",
             &o.min_motion_px,
             "px",
             "below this median motion of the features the camera is at rest; 0: it never is, as in the paper",
             0,
             100,
             {}});
}

void add_third_view_options(OptionTable& table, ClassicOptions& o) {
  table.add({"max_error_px", &o.max_error_px, "px", "maximum reprojection error of an inlier of P3P", 0.1, 50, {}});
  table.add({"refine_iterations",
             &o.refine_iterations,
             "",
             "Gauss-Newton iterations of the pose over the inliers of P3P; 0: as RANSAC leaves it",
             0,
             100,
             {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "RANSAC iterations, at most", 1, 100000, {}});
  table.add({"ransac_confidence",
             &o.ransac_confidence,
             "",
             "probability of a sample without outliers at which RANSAC ends",
             0.5,
             0.999999,
             {}});
  table.add({"min_points", &o.min_points, "", "matches, and points in k, that a motion needs", 5, 10000, {}});
  table.add({"min_inlier_share", &o.min_inlier_share, "", "share of inliers that a motion needs", 0, 1, {}});
  table.add({"max_bridged_frames",
             &o.max_bridged_frames,
             "frames",
             "over so many frames without a pose the last motion is repeated; then the camera stays",
             0,
             1000,
             {}});
}

}  // namespace

void set_paper_preset(ClassicOptions& options) {
  options.min_parallax_deg = 0.0;
  options.min_motion_px = 0.0;
}

OptionTable option_table(ClassicOptions& options) {
  OptionTable table;
  add_feature_options(table, options);
  add_pair_options(table, options);
  add_third_view_options(table, options);
  add_options(table, options.check);
  return table;
}

}  // namespace rastro
