// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/options.h"

#include "rastro/slam/orb/map_options.h"

namespace rastro {
namespace {

void add_feature_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"sensor",
             &o.sensor,
             "",
             "sensors to use: auto: all that the recording has (depth before a second camera), or fewer",
             0,
             0,
             {"auto", "mono", "stereo", "rgbd"}});
  table.add({"features",
             &o.features,
             "",
             "ORB features per image; 0: 1000, and 2000 for images more than a third larger than 640 x 480",
             0,
             20000,
             {}});
  table.add({"levels", &o.levels, "", "levels of the image pyramid (Mur-Artal et al. 2015)", 1, 16, {}});
  table.add({"scale_factor", &o.scale_factor, "", "scale factor between levels", 1.05, 2, {}});
  table.add({"fast_threshold", &o.fast_threshold, "intensity", "threshold of the FAST corner detector", 1, 254, {}});
  table.add({"least_fast_threshold",
             &o.least_fast_threshold,
             "intensity",
             "threshold where a cell has no corner at fast_threshold",
             1,
             254,
             {}});
  table.add({"pixel_sigma",
             &o.pixel_sigma,
             "px",
             "standard deviation of a feature's position at the finest level; it grows with the scale",
             0.05,
             20,
             {}});
  table.add({"more_features",
             &o.more_features,
             "",
             "features of an image where few landmarks are tracked with one camera, as multiple of `features`: in a "
             "turn or among people the static scene stays in the majority; 1: never more",
             1,
             4,
             {}});
  table.add({"few_tracked",
             &o.few_tracked,
             "",
             "tracked landmarks below which more features are extracted; 150 to 200 hold the static scene in the "
             "majority among people",
             0,
             100000,
             {}});
  table.add({"enough_tracked",
             &o.enough_tracked,
             "",
             "tracked landmarks from which no more features than `features` are extracted again",
             0,
             100000,
             {}});
}

void add_depth_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"virtual_baseline_m",
             &o.virtual_baseline_m,
             "m",
             "baseline of a virtual right camera that stands for the depth: sigma grows with depth squared, as a depth "
             "camera's does; 0.4 at 585 px gives 4 mm at 1 m",
             0.01,
             1,
             {}});
  table.add({"depth_edge_sigmas",
             &o.depth_edge_sigmas,
             "sigmas",
             "rms deviation from a plane, of 5x5 depths, beyond which a feature lies at an edge and has no depth: the "
             "camera sees the edge of what is nearer, its depth may be that of what is behind",
             0.1,
             100,
             {}});
  table.add({"far_baselines",
             &o.far_baselines,
             "",
             "depths beyond this many baselines are far: a single one makes no landmark (Mur-Artal and Tardos 2017)",
             5,
             1000,
             {}});
  table.add({"start_depth_points",
             &o.start_depth_points,
             "",
             "features with depth that initialization needs, with a stereo or depth camera; min_inliers of them within "
             "far_baselines",
             20,
             20000,
             {}});
}

void add_stereo_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"stereo_hamming", &o.stereo_hamming, "bits", "maximum Hamming distance of a stereo match", 1, 256, {}});
  table.add({"stereo_disparity_share",
             &o.stereo_disparity_share,
             "",
             "maximum disparity as share of the image width",
             0.01,
             1,
             {}});
  table.add({"stereo_least_disparity_px",
             &o.stereo_least_disparity_px,
             "px",
             "a smaller disparity counts as infinitely far",
             0.01,
             100,
             {}});
  table.add({"stereo_difference_ratio",
             &o.stereo_difference_ratio,
             "",
             "maximum intensity difference of a stereo match, as multiple of the median of all matches",
             0.5,
             100,
             {}});
}

void add_start_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"init_window_share",
             &o.init_window_share,
             "",
             "search window of initialization as share of the image width",
             0.01,
             1,
             {}});
  table.add(
      {"init_hamming", &o.init_hamming, "bits", "maximum Hamming distance of an initialization match", 1, 256, {}});
  table.add({"init_ratio",
             &o.init_ratio,
             "",
             "ratio test of initialization matches: best distance / second best, at most (Lowe 2004)",
             0.1,
             1,
             {}});
  table.add({"init_matches", &o.init_matches, "", "matches that two-view initialization needs", 8, 20000, {}});
  table.add({"init_points",
             &o.init_points,
             "",
             "triangulated points in front of both cameras that initialization needs",
             5,
             20000,
             {}});
  table.add({"init_parallax_deg",
             &o.init_parallax_deg,
             "deg",
             "median parallax angle that initialization needs; a smaller one makes the depth unreliable",
             0.01,
             45,
             {}});
  table.add({"init_homography_share",
             &o.init_homography_share,
             "",
             "S_H / (S_H + S_F) above which the homography is chosen (Mur-Artal et al. 2015, section IV)",
             0,
             1,
             {}});
}

void add_start_trial_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"init_iterations",
             &o.init_iterations,
             "",
             "RANSAC iterations of homography and fundamental matrix, at most",
             10,
             100000,
             {}});
  table.add({"init_frames",
             &o.init_frames,
             "",
             "frames kept before initialization, whose poses are added afterwards",
             2,
             10000,
             {}});
  table.add({"init_trial_frames", &o.init_trial_frames, "", "frames in which a new map is verified", 0, 1000, {}});
  table.add({"init_max_error",
             &o.init_max_error,
             "",
             "mean squared reprojection error of a frame, in squared sigmas; if three frames in a row exceed it, the "
             "new map is dropped and initialization begins again; about 0.5 for a good map",
             0.1,
             100,
             {}});
}

void add_frontend_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"frontend",
             &o.frontend,
             "",
             "matching between frames: orb: descriptors in a search window at the predicted position; tracks: optical "
             "flow with re-identification after occlusion (Galardi et al.)",
             0,
             0,
             {"orb", "tracks"}});
  table.add({"tracks", &o.tracks, "", "features tracked, with frontend tracks", 20, 20000, {}});
  table.add({"tracks_distance_px", &o.tracks_distance_px, "px", "minimum distance between them", 2, 200, {}});
  table.add({"tracks_near_px",
             &o.tracks_near_px,
             "px",
             "maximum distance of a track to a feature with a landmark for the track to observe that landmark",
             0.1,
             20,
             {}});
  table.add({"tracks_kept", &o.tracks_kept, "", "newest tracks whose landmarks are kept", 100, 100000000, {}});
}

void add_search_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"search_px",
             &o.search_px,
             "px",
             "search radius around the predicted positions of the last frame's landmarks, at the finest level; wider "
             "if tracking fails",
             1,
             200,
             {}});
  table.add({"local_search_px",
             &o.local_search_px,
             "px",
             "search radius around the local landmarks, at the finest level",
             0.5,
             100,
             {}});
  table.add(
      {"match_hamming", &o.match_hamming, "bits", "maximum Hamming distance of a match with a landmark", 1, 256, {}});
  table.add({"match_ratio", &o.match_ratio, "", "ratio test: best distance / second best, at most", 0.1, 1, {}});
  table.add({"max_view_angle_deg",
             &o.max_view_angle_deg,
             "deg",
             "maximum angle to the mean viewing direction of a landmark",
             5,
             180,
             {}});
}

void add_verdict_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"min_guess_inliers",
             &o.min_guess_inliers,
             "",
             "inliers that the motion model needs; with fewer, a wider search is tried, then the reference keyframe",
             4,
             1000,
             {}});
  table.add(
      {"min_inliers", &o.min_inliers, "", "inliers that a pose needs; with fewer, tracking is lost", 4, 1000, {}});
  table.add({"localization_inliers",
             &o.localization_inliers,
             "",
             "the same while only localizing in a given map, which a bad pose cannot harm",
             4,
             1000,
             {}});
  table.add(
      {"localization_distance_error",
       &o.localization_distance_error,
       "",
       "standard deviation of a landmark's distance as share of it, at most, to count as one of these inliers; 0: "
       "all count",
       0,
       1,
       {}});
  table.add(
      {"min_chance_ratio",
       &o.min_chance_ratio,
       "",
       "ratio of the inliers of a pose to those that fit by chance plus one, at least; below, tracking is lost. 0: "
       "not compared",
       0,
       10000,
       {}});
  table.add(
      {"max_acceleration",
       &o.max_acceleration,
       "m/s^2",
       "a pose that only a larger acceleration explains is weak, unless one camera gives no meters; 0: not checked",
       0,
       1e6,
       {}});
  table.add({"weak_inliers",
             &o.weak_inliers,
             "",
             "a pose with fewer inliers is weak if less than `weak_share` of its matches are inliers",
             0,
             100000,
             {}});
  table.add({"weak_share",
             &o.weak_share,
             "",
             "share of inliers below which a pose with few of them is weak: something moves, or the map is wrong there",
             0,
             1,
             {}});
}

void add_established_options(OptionTable& table, OrbSlamOptions& o) {
  table.add(
      {"established_inliers",
       &o.established_inliers,
       "",
       "where so many landmarks that three keyframes saw contradict the newer ones, the pose is theirs: what is new "
       "moves",
       10,
       100000,
       {}});
  table.add({"established_share",
             &o.established_share,
             "",
             "share of these landmarks that must fit one pose for that",
             0,
             1,
             {}});
  table.add({"established_contradiction",
             &o.established_contradiction,
             "",
             "squared sigmas between both poses that are a contradiction",
             10,
             1e9,
             {}});
}

void add_local_map_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"pnp_iterations", &o.pnp_iterations, "", "RANSAC iterations of PnP, at most", 10, 100000, {}});
  table.add({"local_keyframes", &o.local_keyframes, "", "keyframes of the local map, at most", 2, 1000, {}});
  table.add({"local_landmarks", &o.local_landmarks, "", "landmarks of the local map, at most", 100, 1000000, {}});
}

void add_keyframe_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"keyframe_frames",
             &o.keyframe_frames,
             "",
             "frames after the last keyframe from which a new one does not wait for mapping to be idle",
             1,
             100000,
             {}});
  table.add({"keyframe_share",
             &o.keyframe_share,
             "",
             "a keyframe is inserted if fewer of the reference keyframe's landmarks are tracked, as share",
             0.05,
             1,
             {}});
  table.add({"keyframe_share_depth",
             &o.keyframe_share_depth,
             "",
             "the same with a stereo or depth camera, where a keyframe brings all its landmarks at once",
             0.05,
             1,
             {}});
  table.add({"keyframe_few_points",
             &o.keyframe_few_points,
             "",
             "with a stereo or depth camera, a keyframe is inserted if fewer landmarks are tracked and "
             "keyframe_new_points are available",
             0,
             10000,
             {}});
  table.add({"keyframe_new_points", &o.keyframe_new_points, "", "see keyframe_few_points", 1, 10000, {}});
  table.add({"backend_delay_frames",
             &o.backend_delay_frames,
             "",
             "minimum pipeline latency: tracking gets the results of mapping this many frames after a keyframe ...",
             1,
             1000,
             {}});
  table.add({"backend_delay_s",
             &o.backend_delay_s,
             "s",
             "... and at least this much later. 0.18 is four frames at 20 Hz",
             0,
             60,
             {}});
}

}  // namespace

OptionTable option_table(OrbSlamOptions& options) {
  OptionTable table;
  add_feature_options(table, options);
  add_depth_options(table, options);
  add_stereo_options(table, options);
  add_start_options(table, options);
  add_start_trial_options(table, options);
  add_frontend_options(table, options);
  add_search_options(table, options);
  add_verdict_options(table, options);
  add_established_options(table, options);
  add_local_map_options(table, options);
  add_keyframe_options(table, options);
  add_mapping_options(table, options);
  add_adjustment_options(table, options);
  add_loss_options(table, options);
  add_place_options(table, options);
  add_relocalization_options(table, options);
  add_loop_options(table, options);
  add_loop_drift_options(table, options);
  add_covariance_options(table, options);
  add_options(table, options.frame_check);
  return table;
}

}  // namespace rastro
