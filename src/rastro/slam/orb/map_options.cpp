// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map_options.h"

namespace rastro {

void add_mapping_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"cull_found_share",
             &o.cull_found_share,
             "",
             "a new landmark is removed if it is found in a smaller share of the frames that should observe it",
             0,
             1,
             {}});
  table.add({"cull_keyframes", &o.cull_keyframes, "", "keyframes after which a landmark is no longer new", 1, 100, {}});
  table.add({"triangulate_neighbors",
             &o.triangulate_neighbors,
             "",
             "covisible keyframes for triangulation and landmark fusion",
             1,
             200,
             {}});
  table.add({"triangulate_hamming",
             &o.triangulate_hamming,
             "bits",
             "maximum Hamming distance of a match to be triangulated",
             1,
             256,
             {}});
  table.add({"triangulate_parallax_deg",
             &o.triangulate_parallax_deg,
             "deg",
             "minimum parallax angle of a new landmark",
             0.01,
             45,
             {}});
  table.add({"epipolar_chi2",
             &o.epipolar_chi2,
             "",
             "maximum squared epipolar error in squared sigmas: 95 % with one degree of freedom",
             0.1,
             100,
             {}});
  table.add({"fuse_px", &o.fuse_px, "px", "search radius for landmark fusion", 0.5, 50, {}});
  table.add_former_name("triangulate_neighbours", "triangulate_neighbors");
}

void add_adjustment_options(OptionTable& table, OrbSlamOptions& o) {
  table.add(
      {"adjust_keyframes", &o.adjust_keyframes, "", "covisible keyframes of local bundle adjustment", 1, 1000, {}});
  table.add({"adjust_fixed", &o.adjust_fixed, "", "fixed keyframes of local bundle adjustment, at most", 1, 1000, {}});
  table.add(
      {"adjust_iterations", &o.adjust_iterations, "", "iterations of local bundle adjustment, at most", 1, 1000, {}});
  table.add({"final_iterations",
             &o.final_iterations,
             "",
             "iterations of global bundle adjustment at the end; 0: none",
             0,
             1000,
             {}});
  table.add({"final_keyframes",
             &o.final_keyframes,
             "",
             "a map with more keyframes gets no global bundle adjustment at the end",
             0,
             1000000,
             {}});
  table.add({"cull_seen_share",
             &o.cull_seen_share,
             "",
             "a keyframe is redundant if this share of its landmarks is observed by three others at the same or a "
             "finer scale",
             0.1,
             1,
             {}});
  table.add({"covisible_landmarks",
             &o.covisible_landmarks,
             "",
             "shared landmarks that make two keyframes covisible",
             1,
             1000,
             {}});
}

void add_loss_options(OptionTable& table, OrbSlamOptions& o) {
  table.add(
      {"lost_frames", &o.lost_frames, "", "frames without tracking before a new submap is started", 1, 1000000, {}});
  table.add({"settled_frames",
             &o.settled_frames,
             "",
             "frames after relocalization before a keyframe is inserted, unless half of the landmarks that fit then "
             "are out of "
             "view",
             0,
             10000,
             {}});
  table.add({"seed", &o.seed, "", "seed of the random numbers", 0, 0, {}});
}

void add_place_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"loop_closing",
             &o.loop_closing,
             "",
             "detect loops, correct the map and merge submaps; false: relocalization only",
             0,
             1,
             {}});
  table.add({"essential_landmarks",
             &o.essential_landmarks,
             "",
             "shared landmarks that make an edge of the essential graph",
             15,
             10000,
             {}});
  table.add({"place_shared_words",
             &o.place_shared_words,
             "",
             "minimum number of shared words of a candidate, as share of the most shared ones",
             0,
             1,
             {}});
  table.add({"place_candidates",
             &o.place_candidates,
             "",
             "place recognition candidates that are verified, best first",
             1,
             1000,
             {}});
  table.add(
      {"place_hamming", &o.place_hamming, "", "maximum Hamming distance of a match with a candidate", 1, 256, {}});
  table.add({"place_ratio",
             &o.place_ratio,
             "",
             "ratio test of these matches: best distance / second best, at most",
             0.1,
             1,
             {}});
}

void add_relocalization_options(OptionTable& table, OrbSlamOptions& o) {
  table.add(
      {"relocalize_matches", &o.relocalize_matches, "", "matches that a relocalization candidate needs", 4, 10000, {}});
  table.add({"relocalize_search_px",
             &o.relocalize_search_px,
             "px",
             "search radius around the predicted positions after the first pose, at the finest level",
             0.5,
             100,
             {}});
  table.add({"relocalize_frames",
             &o.relocalize_frames,
             "",
             "frames in a row that must fit the map before a relocalization is believed; until then they are lost with "
             "reason unconfirmed",
             1,
             100,
             {}});
  table.add(
      {"relocalize_chance_ratio",
       &o.relocalize_chance_ratio,
       "",
       "ratio of the inliers of these frames to those that fit by chance, plus one per frame, at least; 2 to 3.7 in "
       "a wrong place of a street, 5 to 30 in the right one",
       0,
       10000,
       {}});
  table.add({"relocalize_visible_share",
             &o.relocalize_visible_share,
             "",
             "share of the landmarks that would be visible from there which fit in these frames, at least; 0.04 in "
             "another corridor of the same make",
             0,
             1,
             {}});
  table.add_former_name("relocalise_matches", "relocalize_matches");
  table.add_former_name("relocalise_search_px", "relocalize_search_px");
}

void add_loop_options(OptionTable& table, OrbSlamOptions& o) {
  table.add(
      {"loop_neighbor_landmarks",
       &o.loop_neighbor_landmarks,
       "",
       "shared landmarks that make a keyframe a neighbor; a loop candidate must score higher than the lowest neighbor",
       1,
       10000,
       {}});
  table.add(
      {"loop_consistent", &o.loop_consistent, "", "consecutive keyframes that must detect the same loop", 1, 100, {}});
  table.add(
      {"loop_inliers", &o.loop_inliers, "", "inliers that the similarity transform of a loop needs", 4, 10000, {}});
  table.add({"loop_landmarks", &o.loop_landmarks, "", "matches of landmarks that a verified loop needs", 4, 10000, {}});
  table.add({"loop_search_px",
             &o.loop_search_px,
             "px",
             "search radius around the positions predicted by the similarity, at the finest level",
             0.5,
             10000,
             {}});
  table.add(
      {"loop_chance_ratio",
       &o.loop_chance_ratio,
       "",
       "ratio of the landmarks found with the similarity of a loop to those found by chance plus one, at least; 7 "
       "to 9 in wrong loops, 15 to 50 in right ones",
       0,
       10000,
       {}});
  table.add({"loop_fit_share",
             &o.loop_fit_share,
             "",
             "share of the landmarks found with the similarity of a loop that are where it predicts them within their "
             "accuracy, at least; 0.6 with a similarity that is half right, 0.9 and more with right ones",
             0,
             1,
             {}});
  table.add(
      {"loop_min_gap", &o.loop_min_gap, "", "minimum number of keyframes between two loop closures", 0, 100000, {}});
  table.add({"loop_adjust_iterations",
             &o.loop_adjust_iterations,
             "",
             "iterations of global bundle adjustment after a loop closure, at most",
             0,
             1000,
             {}});
  table.add({"loop_adjust_delay_s",
             &o.loop_adjust_delay_s,
             "s",
             "latency of global bundle adjustment after a loop closure per 100000 observations; with a shorter one "
             "tracking may wait for it",
             0,
             1000,
             {}});
  table.add_former_name("loop_neighbour_landmarks", "loop_neighbor_landmarks");
  table.add_former_name("loop_apart", "loop_min_gap");
}

void add_loop_drift_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"loop_drift_share",
             &o.loop_drift_share,
             "",
             "assumed standard deviation of the drift between two keyframes, as share of the path between them; a loop "
             "that contradicts it is rejected",
             0.001,
             10,
             {}});
  table.add({"loop_drift_rad_per_m",
             &o.loop_drift_rad_per_m,
             "rad/m",
             "the same of the orientation; with one camera per unit of the map",
             0.0001,
             10,
             {}});
  table.add({"loop_max_sigmas",
             &o.loop_max_sigmas,
             "",
             "largest distance of a loop from the relative pose in the map, in standard deviations of that drift",
             1,
             1e9,
             {}});
}

void add_covariance_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"adjusted_rotation_share",
             &o.adjusted_rotation_share,
             "",
             "share of a new keyframe's rotation sigma that bundle adjustment leaves, for the covariances of poses",
             0,
             1,
             {}});
  table.add({"position_drift_factor",
             &o.position_drift_factor,
             "",
             "factor on a new keyframe's position sigma, for the covariances of poses: successive keyframes see the "
             "same landmarks, so their errors are alike",
             0,
             100,
             {}});
  table.add({"scale_drift_share",
             &o.scale_drift_share,
             "",
             "standard deviation of the drift of the scale from a keyframe to the next with one camera, as share, for "
             "the covariances of poses",
             0,
             1,
             {}});
}

}  // namespace rastro
