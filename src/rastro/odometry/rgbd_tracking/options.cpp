// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/options.h"

namespace rastro {
namespace {

void add_depth_options(OptionTable& table, RgbdOptions& o) {
  table.add(
      {"depth_sigma_m", &o.depth_sigma_m, "m", "part of the depth noise that does not grow with depth", 0, 1, {}});
  table.add({"weak_sigma",
             &o.weak_sigma,
             "",
             "a pose with a larger standard deviation in any direction is weak, meters and radians",
             0.0001,
             1,
             {}});
  table.add(
      {"depth_sigma_per_m2",
       &o.depth_sigma_per_m2,
       "1/m",
       "the depth noise is depth_sigma_m + this * depth^2: its disparity is quantized (Khoshelham and Elberink 2012)",
       1e-6,
       1,
       {}});
  table.add({"depth_edge_sigmas",
             &o.depth_edge_sigmas,
             "sigmas",
             "rms deviation from a plane, of 5x5 depths, beyond which a pixel lies at an edge and has no depth",
             0.1,
             100,
             {}});
  table.add({"min_depth_m", &o.min_depth_m, "m", "minimum depth used", 0, 100, {}});
  table.add({"max_depth_m", &o.max_depth_m, "m", "maximum depth used", 0.1, 1000, {}});
  table.add({"learn_delay",
             &o.learn_delay,
             "",
             "estimate the delay of depth after its stamps; in a fast rotation it is worth many pixels",
             0,
             1,
             {}});
}

void add_feature_options(OptionTable& table, RgbdOptions& o) {
  table.add({"features", &o.features, "", "number of features kept in a frame", 20, 5000, {}});
  table.add({"min_distance_px", &o.min_distance_px, "px", "minimum distance between features", 1, 500, {}});
  table.add({"patch_px", &o.patch_px, "px", "side of a feature's square patch, odd", 5, 31, {}});
  table.add({"pixel_sigma",
             &o.pixel_sigma,
             "px",
             "standard deviation of a feature's position, at least: what a recording shows to be larger is learned",
             0.05,
             20,
             {}});
  table.add(
      {"shared_error_px",
       &o.shared_error_px,
       "px",
       "error that all features of a frame may share, as color and depth are never registered perfectly: surfaces "
       "that match better prevail",
       0,
       20,
       {}});
  table.add({"max_error_px", &o.max_error_px, "px", "maximum reprojection error of an inlier", 0.1, 50, {}});
  table.add({"min_points", &o.min_points, "", "inliers that a pose from features alone needs", 4, 1000, {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "RANSAC iterations, at most", 1, 100000, {}});
  table.add({"seed", &o.seed, "", "seed of the random numbers", 0, 1e18, {}});
}

void add_surface_options(OptionTable& table, RgbdOptions& o) {
  table.add({"surfaces",
             &o.surfaces,
             "",
             "on: surfaces are aligned together with the features, each weighted by its information; off: features "
             "alone",
             0,
             0,
             {"on", "off"}});
  table.add({"surface_weight",
             &o.surface_weight,
             "",
             "weight of a block of 4 x 4 depths; 1 treats the errors of neighboring blocks as independent",
             0,
             1,
             {}});
}

void add_reference_options(OptionTable& table, RgbdOptions& o) {
  table.add({"max_reference_rotation_deg",
             &o.max_reference_rotation_deg,
             "deg",
             "a frame becomes a reference if it is rotated by more against every reference near it",
             0.5,
             90,
             {}});
  table.add({"max_reference_motion_m",
             &o.max_reference_motion_m,
             "",
             "a frame becomes a reference if it is farther from every reference, as share of the median depth",
             0.01,
             2,
             {}});
  table.add({"min_reference_share",
             &o.min_reference_share,
             "",
             "a frame becomes a reference if a smaller share of its features matches the local map",
             0,
             1,
             {}});
  table.add({"map_references", &o.map_references, "", "number of references whose features are kept", 2, 1000, {}});
  table.add_former_name("max_reference_turn_deg", "max_reference_rotation_deg");
  table.add_former_name("max_reference_way", "max_reference_motion_m");
}

}  // namespace

OptionTable option_table(RgbdOptions& options) {
  OptionTable table;
  add_depth_options(table, options);
  add_feature_options(table, options);
  add_surface_options(table, options);
  add_reference_options(table, options);
  add_options(table, options.frame_check);
  return table;
}

}  // namespace rastro
