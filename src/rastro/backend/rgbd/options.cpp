// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/options.h"

#include <algorithm>

namespace rastro {
namespace {

void add_keyframe_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add(
      {"descriptor",
       &o.descriptor,
       "",
       "features for matching keyframes: orb; even_orb: spread over the "
       "image and the pyramid, as the vocabulary knows them; sift: the most robust to large rotations and distances",
       0,
       0,
       {"orb", "even_orb", "sift", "surf"}});
  table.add({"keyframe_features", &o.keyframe_features, "", "features per keyframe", 30, 5000, {}});
  table.add({"keyframe_distance_m",
             &o.keyframe_distance_m,
             "m",
             "translation after which a keyframe is inserted, besides those that tracking needs",
             0.01,
             10,
             {}});
  table.add(
      {"keyframe_angle_rad", &o.keyframe_angle_rad, "rad", "rotation after which a keyframe is inserted", 0.01, 3, {}});
  table.add({"keyframe_frames",
             &o.keyframe_frames,
             "",
             "frames after which a keyframe is inserted in any case",
             1,
             100000,
             {}});
  table.add(
      {"dense_keyframes",
       &o.dense_keyframes,
       "",
       "where the map has that many keyframes within the distance and angle above, a frame is matched with one of "
       "them instead of becoming one more: memory grows with the places, not with the time",
       1,
       100000,
       {}});
}

void add_candidate_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add(
      {"last_candidates", &o.last_candidates, "", "previous keyframes that a new one is matched with", 0, 100, {}});
  table.add(
      {"near_candidates",
       &o.near_candidates,
       "",
       "keyframes nearest in estimated position and orientation that a new one is matched with: so many of the last "
       "graph_window, and as many of those before",
       0,
       100,
       {}});
  table.add({"graph_candidates",
             &o.graph_candidates,
             "",
             "random keyframes among the graph neighbors that a new one is matched with",
             0,
             100,
             {}});
  table.add({"random_candidates",
             &o.random_candidates,
             "",
             "random keyframes of the map that a new one is matched with: finds loops despite large drift",
             0,
             100,
             {}});
  table.add({"join_candidates",
             &o.join_candidates,
             "",
             "random keyframes of other submaps that a new one is matched with",
             0,
             100,
             {}});
  table.add({"near_distance_m", &o.near_distance_m, "m", "maximum distance of near_candidates", 0.01, 100, {}});
  table.add({"near_angle_rad", &o.near_angle_rad, "rad", "maximum rotation of near_candidates", 0.01, 3.2, {}});
}

void add_matching_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add(
      {"max_ratio", &o.max_ratio, "", "ratio test: best distance / second best, at most (Lowe 2004)", 0.1, 1, {}});
  table.add({"keyframe_pixel_sigma",
             &o.pixel_sigma,
             "px",
             "standard deviation of a feature's position at the finest scale",
             0.05,
             20,
             {}});
  table.add({"keyframe_ransac_iterations",
             &o.ransac_iterations,
             "",
             "RANSAC iterations per pair of keyframes, at most",
             1,
             100000,
             {}});
  table.add({"min_inliers", &o.min_inliers, "", "inliers that a constraint from features alone needs", 6, 5000, {}});
  table.add({"loop_inliers", &o.loop_inliers, "", "the same for a loop closure", 6, 5000, {}});
  table.add(
      {"match_far",
       &o.match_far,
       "",
       "features without a depth in either keyframe count as well, by their direction: what is beyond the range of "
       "the depth camera",
       0,
       1,
       {}});
  table.add({"few_features",
             &o.few_features,
             "",
             "with fewer inliers: icp aligns the surfaces (point-to-plane ICP), refuse adds no constraint",
             0,
             0,
             {"icp", "refuse"}});
  table.add({"few_inliers", &o.few_inliers, "", "inliers that icp needs", 4, 5000, {}});
  table.add({"min_inlier_share",
             &o.min_inlier_share,
             "",
             "share of inliers among the matches that a constraint needs",
             0,
             1,
             {}});
}

void add_agreement_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add(
      {"agreement",
       &o.agreement,
       "",
       "share of the common surfaces that must agree in depth: the environment measurement model (Endres et al. 2014)",
       0,
       1,
       {}});
  table.add(
      {"agreement_overlap", &o.agreement_overlap, "", "share of the depth that must overlap for this check", 0, 1, {}});
  table.add({"min_alike",
             &o.min_alike,
             "",
             "share of the textured patches that must look alike, with 95 % confidence, for a loop closure, to merge "
             "submaps, and to relocalize: corridors of one make have the same shape; 0: not checked",
             0,
             1,
             {}});
  table.add({"edge_sigma_m",
             &o.edge_sigma_m,
             "m",
             "minimum standard deviation of a constraint: errors of lens, clocks and depth are correlated",
             0,
             1,
             {}});
  table.add({"edge_sigma_rad", &o.edge_sigma_rad, "rad", "the same for the rotation", 0, 1, {}});
}

void add_graph_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add({"loops",
             &o.loops,
             "",
             "robust loop closures: switchable constraints (Suenderhauf and Protzel 2012) or the Cauchy kernel",
             0,
             0,
             {"switchable", "robust"}});
  table.add({"switch_price",
             &o.switch_price,
             "",
             "cost in squared sigmas of disabling a constraint; correct ones have 6 on average",
             1,
             1e6,
             {}});
  table.add({"robust_width", &o.robust_width, "", "width of the Cauchy kernel in sigmas", 0.1, 1000, {}});
  table.add({"graph_window",
             &o.graph_window,
             "",
             "previous keyframes optimized with each new one; loop closures optimize all",
             2,
             1000,
             {}});
}

void add_drift_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add({"loop_steps",
             &o.loop_steps,
             "",
             "a constraint is a loop closure if the shortest path of other constraints has at least this many",
             2,
             1000,
             {}});
  table.add({"loop_drift_share",
             &o.loop_drift_share,
             "",
             "assumed standard deviation of the drift between two keyframes, as share of the path between them; a loop "
             "that contradicts it is rejected",
             0.001,
             10,
             {}});
  table.add({"loop_drift_rad_per_m", &o.loop_drift_rad_per_m, "rad/m", "the same of the orientation", 0.0001, 10, {}});
  table.add({"loop_max_sigmas",
             &o.loop_max_sigmas,
             "",
             "largest distance of a loop from the relative pose in the map, in standard deviations of that drift",
             1,
             1e9,
             {}});
  table.add(
      {"tracked_drift_share",
       &o.tracked_drift_share,
       "",
       "drift beside what the covariances of tracking say, where it was not lost between two keyframes: per meter "
       "of path, in meters and radians; a match that contradicts it shows something that moves",
       0.0001,
       10,
       {}});
  table.add({"max_acceleration",
             &o.max_acceleration,
             "m/s^2",
             "a pose that only a larger acceleration explains is weak; 0: not checked",
             0,
             1e6,
             {}});
}

void add_pace_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add(
      {"optimize_iterations", &o.optimize_iterations, "", "iterations of each optimization, at most", 1, 1000, {}});
  table.add({"backend_delay_frames",
             &o.backend_delay_frames,
             "",
             "pipeline latency: tracking gets the results of mapping this many frames after a keyframe",
             1,
             1000,
             {}});
}

void add_loss_options(OptionTable& table, RgbdSlamOptions& o) {
  table.add({"relocalize_every",
             &o.relocalize_every,
             "",
             "every n-th lost frame is relocalized, of the first five each",
             1,
             1000,
             {}});
  table.add(
      {"relocalize_last", &o.relocalize_last, "", "previous keyframes that a lost frame is matched with", 0, 1000, {}});
  table.add({"relocalize_random",
             &o.relocalize_random,
             "",
             "random keyframes that a lost frame is matched with, and as many in turn",
             0,
             1000,
             {}});
  table.add({"relocalize_inliers",
             &o.relocalize_inliers,
             "",
             "inliers that relocalization and merging of submaps need",
             6,
             5000,
             {}});
  table.add(
      {"relocalize_frames",
       &o.relocalize_frames,
       "",
       "frames in a row that must be found in the same place before a relocalization is believed; until then they "
       "are lost with reason unconfirmed",
       1,
       100,
       {}});
  table.add(
      {"lost_frames", &o.lost_frames, "", "frames without tracking before a new submap is started", 1, 1000000, {}});
  table.add({"lost_s", &o.lost_s, "s", "the same in seconds, for slow cameras: whichever is shorter", 0.01, 1e6, {}});
  table.add({"memory_reserve_mb",
             &o.memory_reserve_mb,
             "MB",
             "part of --max-memory reserved for everything but the features of the map",
             0,
             1e6,
             {}});
  table.add_former_name("relocalise_every", "relocalize_every");
  table.add_former_name("relocalise_last", "relocalize_last");
  table.add_former_name("relocalise_random", "relocalize_random");
  table.add_former_name("relocalise_inliers", "relocalize_inliers");
}

}  // namespace

OptionTable option_table(RgbdSlamOptions& options) {
  OptionTable table;
  add_keyframe_options(table, options);
  add_candidate_options(table, options);
  add_matching_options(table, options);
  add_agreement_options(table, options);
  add_graph_options(table, options);
  add_drift_options(table, options);
  add_pace_options(table, options);
  add_loss_options(table, options);
  const OptionTable follow = option_table(options.follow);
  for (const Option& option : follow.options()) table.add(option);
  return table;
}

}  // namespace rastro
