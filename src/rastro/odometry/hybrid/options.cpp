// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/hybrid/options.h"

namespace rastro {
namespace {

void add_start_options(OptionTable& table, HybridOptions& o) {
  table.add({"features", &o.features, "", "points followed in a frame", 8, 20000, {}});
  table.add({"min_distance_px", &o.min_distance_px, "px", "least distance between them", 1, 500, {}});
  table.add({"seed", &o.seed, "", "of every random draw", 0, 9.0e15, {}});
  table.add({"min_start_parallax_px",
             &o.min_start_parallax_px,
             "px",
             "median motion beyond the turn that two frames need before points are triangulated from them to start",
             0.1,
             1000,
             {}});
  table.add({"min_motion_px",
             &o.min_motion_px,
             "px",
             "with a smaller median motion of the points the camera stands still",
             0,
             100,
             {}});
}

void add_follow_options(OptionTable& table, HybridOptions& o) {
  table.add({"min_parallax_px",
             &o.min_parallax_px,
             "px",
             "median motion beyond the turn since k-1 that a frame needs to take the place of k-1: a better one is "
             "waited for. 0: every frame does, the paper's way",
             0,
             1000,
             {}});
  table.add(
      {"max_error_px",
       &o.max_error_px,
       "px",
       "points farther from where the motion puts them do not support it; turns without pitch and roll leave some px",
       0.1,
       100,
       {}});
  table.add({"max_point_error_px",
             &o.max_point_error_px,
             "px",
             "points triangulated from k-2 and k-1 that fit these views worse are left out",
             0.1,
             100,
             {}});
  table.add({"min_point_parallax_deg",
             &o.min_point_parallax_deg,
             "deg",
             "points whose two views differ by less in direction are left out",
             0,
             45,
             {}});
  table.add({"min_points", &o.min_points, "", "fewest points that a motion is sought from", 4, 10000, {}});
  table.add(
      {"min_inlier_share", &o.min_inlier_share, "", "share of the points that must support the motion", 0, 1, {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "most samples drawn for one motion", 1, 100000, {}});
  table.add({"max_speed_ratio",
             &o.max_speed_ratio,
             "",
             "a motion longer than this times the last one is not believed",
             1,
             1e6,
             {}});
  table.add({"max_bridged_frames",
             &o.max_bridged_frames,
             "frames",
             "over so many frames without a use the last motion is carried on; then none is",
             0,
             1000,
             {}});
}

}  // namespace

OptionTable option_table(HybridOptions& options) {
  OptionTable table;
  add_start_options(table, options);
  add_follow_options(table, options);
  add_options(table, options.rotation);
  add_options(table, options.check);
  return table;
}

}  // namespace rastro
