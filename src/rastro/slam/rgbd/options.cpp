// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/options.h"

#include <algorithm>

namespace rastro {
namespace {

void add_keyframe_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add({"descriptor",
             &o.descriptor,
             "",
             "features by which keyframes are compared: orb is the fastest, sift bears the largest turns and steps",
             0,
             0,
             {"orb", "sift", "surf"}});
  table.add({"keyframe_features", &o.keyframe_features, "", "features kept of a keyframe", 30, 5000, {}});
  table.add({"keyframe_distance_m",
             &o.keyframe_distance_m,
             "m",
             "way after which a frame is kept, besides those the follower needs",
             0.01,
             10,
             {}});
  table.add({"keyframe_angle_rad", &o.keyframe_angle_rad, "rad", "turn after which a frame is kept", 0.01, 3, {}});
  table.add({"keyframe_frames", &o.keyframe_frames, "", "frames after which one is kept in any case", 1, 100000, {}});
}

void add_candidate_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add({"last_candidates", &o.last_candidates, "", "last keyframes that a new one is compared with", 0, 100, {}});
  table.add({"near_candidates",
             &o.near_candidates,
             "",
             "keyframes nearest by where they stand and look, as far as is known",
             0,
             100,
             {}});
  table.add({"graph_candidates", &o.graph_candidates, "", "drawn from those a few ties away in the graph", 0, 100, {}});
  table.add({"random_candidates",
             &o.random_candidates,
             "",
             "drawn from all: finds loops where the drift is too large for the nearest",
             0,
             100,
             {}});
  table.add({"join_candidates", &o.join_candidates, "", "drawn from other submaps while there are any", 0, 100, {}});
  table.add({"near_distance_m", &o.near_distance_m, "m", "farther keyframes are not near", 0.01, 100, {}});
  table.add(
      {"near_angle_rad", &o.near_angle_rad, "rad", "keyframes that look farther aside are not near", 0.01, 3.2, {}});
}

void add_matching_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add({"max_ratio",
             &o.max_ratio,
             "",
             "the best match is at most this share as far as the second best (Lowe 2004)",
             0.1,
             1,
             {}});
  table.add({"keyframe_pixel_sigma",
             &o.pixel_sigma,
             "px",
             "standard deviation of the place of a feature of the finest scale",
             0.05,
             20,
             {}});
  table.add({"keyframe_ransac_iterations",
             &o.ransac_iterations,
             "",
             "most samples drawn for a pair of keyframes",
             1,
             100000,
             {}});
  table.add({"min_inliers",
             &o.min_inliers,
             "",
             "matches that must agree on how two keyframes stand for these to decide",
             6,
             5000,
             {}});
  table.add(
      {"few_features",
       &o.few_features,
       "",
       "where fewer matches agree: the surfaces decide, slid onto each other (point-to-plane ICP), or there is no tie",
       0,
       0,
       {"icp", "refuse"}});
  table.add({"few_inliers", &o.few_inliers, "", "matches that must agree for surfaces to be tried", 4, 5000, {}});
  table.add({"min_inlier_share", &o.min_inlier_share, "", "share of all matches that must agree", 0, 1, {}});
}

void add_agreement_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add({"agreement",
             &o.agreement,
             "",
             "share of the surfaces seen by both that must be where both say: the environment measurement check "
             "(Endres et al. 2014)",
             0,
             1,
             {}});
  table.add({"agreement_overlap",
             &o.agreement_overlap,
             "",
             "share of the depth that both must see for this check",
             0,
             1,
             {}});
  table.add({"edge_sigma_m",
             &o.edge_sigma_m,
             "m",
             "what a tie of two keyframes is never surer than: lens, clocks and depth have errors in common",
             0,
             1,
             {}});
  table.add({"edge_sigma_rad", &o.edge_sigma_rad, "rad", "the same of its rotation", 0, 1, {}});
}

void add_graph_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add({"loops",
             &o.loops,
             "",
             "ties that may be wrong: each with a switch that turns it off (Suenderhauf and Protzel 2012), or with "
             "Cauchy's kernel",
             0,
             0,
             {"switchable", "robust"}});
  table.add({"switch_price",
             &o.switch_price,
             "",
             "squared sigmas that turning a tie off costs; right ones have 6 on average",
             1,
             1e6,
             {}});
  table.add({"robust_width", &o.robust_width, "", "sigmas from which Cauchy's kernel bends", 0.1, 1000, {}});
  table.add(
      {"graph_window", &o.graph_window, "", "last keyframes that each new one moves; loops move all", 2, 1000, {}});
  table.add({"loop_steps",
             &o.loop_steps,
             "",
             "a tie is a loop where the way along the others has at least so many",
             2,
             1000,
             {}});
  table.add({"optimize_iterations", &o.optimize_iterations, "", "at most, of each optimisation", 1, 1000, {}});
  table.add({"backend_delay_frames",
             &o.backend_delay_frames,
             "",
             "so many frames later the tracker learns what a keyframe told: the time mapping has beside it",
             1,
             1000,
             {}});
}

void add_loss_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add({"relocalise_every",
             &o.relocalise_every,
             "",
             "of so many lost frames one is looked for in the map",
             1,
             1000,
             {}});
  table.add({"relocalise_last", &o.relocalise_last, "", "last keyframes it is compared with", 0, 1000, {}});
  table.add({"relocalise_random",
             &o.relocalise_random,
             "",
             "keyframes drawn at random it is compared with, and so many more by turns",
             1,
             1000,
             {}});
  table.add({"relocalise_inliers",
             &o.relocalise_inliers,
             "",
             "matches that must agree for a frame to be found again, or for two submaps to be joined",
             6,
             5000,
             {}});
  table.add({"lost_frames",
             &o.lost_frames,
             "",
             "frames in which nothing known was seen before a new submap is begun",
             1,
             1000000,
             {}});
  table.add({"memory_reserve_mb",
             &o.memory_reserve_mb,
             "MB",
             "of --max-memory, what is left for everything but the map's features",
             0,
             1e6,
             {}});
}

}  // namespace

OptionTable option_table(RgbdSlamOptions& options) {
  OptionTable table;
  add_keyframe_options(table, options);
  add_candidate_options(table, options);
  add_matching_options(table, options);
  add_agreement_options(table, options);
  add_graph_options(table, options);
  add_loss_options(table, options);
  const OptionTable follow = option_table(options.follow);
  for (const Option& option : follow.options()) table.add(option);
  return table;
}

}  // namespace rastro
