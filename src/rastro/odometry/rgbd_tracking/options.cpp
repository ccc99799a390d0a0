// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/options.h"

namespace rastro {
namespace {

void add_depth_options(OptionTable& table, RgbdOptions& o) {
  table.add(
      {"depth_sigma_m", &o.depth_sigma_m, "m", "part of the depth's noise that does not grow with depth", 0, 1, {}});
  table.add(
      {"depth_sigma_per_m2",
       &o.depth_sigma_per_m2,
       "1/m",
       "depth's noise is depth_sigma_m + this * depth^2: its disparity is quantised (Khoshelham and Elberink 2012)",
       0,
       1,
       {}});
  table.add({"min_depth_m", &o.min_depth_m, "m", "nearer depths are not used", 0, 100, {}});
  table.add({"max_depth_m", &o.max_depth_m, "m", "farther depths are not used", 0.1, 1000, {}});
  table.add({"learn_delay",
             &o.learn_delay,
             "",
             "learn how much later depth was taken than its stamps say, which in a fast turn is many pixels",
             0,
             1,
             {}});
}

void add_feature_options(OptionTable& table, RgbdOptions& o) {
  table.add({"features", &o.features, "", "features held in a frame", 20, 5000, {}});
  table.add({"min_distance_px", &o.min_distance_px, "px", "least distance between features", 1, 500, {}});
  table.add({"patch_px", &o.patch_px, "px", "side of the square a feature is recognised by, odd", 5, 31, {}});
  table.add({"pixel_sigma", &o.pixel_sigma, "px", "standard deviation of a feature's place", 0.05, 20, {}});
  table.add(
      {"shared_error_px",
       &o.shared_error_px,
       "px",
       "error that all features of a frame may share, as colour is never quite registered to depth: surfaces that "
       "fit better decide",
       0,
       20,
       {}});
  table.add({"max_error_px", &o.max_error_px, "px", "reprojection error of an inlier", 0.1, 50, {}});
  table.add({"min_points", &o.min_points, "", "inliers a pose from features alone must have", 4, 1000, {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "most samples drawn for one motion", 1, 100000, {}});
  table.add({"seed", &o.seed, "", "of every random draw", 0, 1e18, {}});
}

void add_surface_options(OptionTable& table, RgbdOptions& o) {
  table.add(
      {"surfaces",
       &o.surfaces,
       "",
       "on: surfaces are fitted together with the features, each weighing what the scene offers of it; off: features "
       "alone",
       0,
       0,
       {"on", "off"}});
  table.add({"surface_weight",
             &o.surface_weight,
             "",
             "how much a block of 4 x 4 depths counts, 1 being as if none erred together with its neighbours",
             0,
             1,
             {}});
}

void add_reference_options(OptionTable& table, RgbdOptions& o) {
  table.add({"max_reference_turn_deg",
             &o.max_reference_turn_deg,
             "deg",
             "a frame turned by more against every reference near it becomes a reference",
             0.5,
             90,
             {}});
  table.add({"max_reference_way",
             &o.max_reference_way,
             "",
             "a frame farther from every reference, as share of the median depth, becomes a reference",
             0.01,
             2,
             {}});
  table.add({"min_reference_share",
             &o.min_reference_share,
             "",
             "a frame in which fewer of the asked features are seen again becomes a reference",
             0,
             1,
             {}});
  table.add({"map_references", &o.map_references, "", "references whose features are kept", 2, 1000, {}});
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
