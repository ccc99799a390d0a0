// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/hybrid/options.h"

namespace rastro {
namespace {

void add_start_options(OptionTable& table, HybridOptions& o) {
  table.add({"features", &o.features, "", "number of points tracked in a frame", 8, 20000, {}});
  table.add({"min_distance_px", &o.min_distance_px, "px", "minimum distance between them", 1, 500, {}});
  table.add({"seed", &o.seed, "", "seed of the random numbers", 0, 9.0e15, {}});
  table.add({"min_start_parallax_px",
             &o.min_start_parallax_px,
             "px",
             "parallax (median motion beyond the rotation) that two frames need for initialization",
             0.1,
             1000,
             {}});
  table.add({"min_motion_px",
             &o.min_motion_px,
             "px",
             "below this median motion of the points the camera is at rest",
             0,
             100,
             {}});
}

void add_follow_options(OptionTable& table, HybridOptions& o) {
  table.add({"min_parallax_px",
             &o.min_parallax_px,
             "px",
             "parallax (median motion beyond the rotation) since k-1 at which a frame replaces k-1; until then it "
             "waits. 0: every frame does, as in the paper",
             0,
             1000,
             {}});
  table.add({"max_error_px",
             &o.max_error_px,
             "px",
             "maximum reprojection error of an inlier; rotations without pitch and roll leave some px",
             0.1,
             100,
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
             "minimum angle between two rays to triangulate a point",
             0,
             45,
             {}});
  table.add({"min_points", &o.min_points, "", "points that a motion needs", 4, 10000, {}});
  table.add({"min_inlier_share", &o.min_inlier_share, "", "share of inliers that a motion needs", 0, 1, {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "RANSAC iterations, at most", 1, 100000, {}});
  table.add({"max_speed_ratio",
             &o.max_speed_ratio,
             "",
             "a motion longer than this times the last one is rejected",
             1,
             1e6,
             {}});
  table.add({"max_bridged_frames",
             &o.max_bridged_frames,
             "frames",
             "over so many rejected frames the last motion is repeated; further ones count as lost",
             0,
             1000,
             {}});
}

}  // namespace

void set_paper_preset(HybridOptions& options) {
  options.min_parallax_px = 0.0;
  set_paper_preset(options.rotation);
}

OptionTable option_table(HybridOptions& options) {
  OptionTable table;
  add_start_options(table, options);
  add_follow_options(table, options);
  add_options(table, options.rotation);
  add_options(table, options.check);
  return table;
}

}  // namespace rastro
