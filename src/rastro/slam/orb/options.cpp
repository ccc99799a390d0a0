// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/options.h"

namespace rastro {
namespace {

void add_feature_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"sensor",
             &o.sensor,
             "",
             "what to use of the recording: all it has (depth before a second camera), or less",
             0,
             0,
             {"auto", "mono", "stereo", "rgbd"}});
  table.add({"features",
             &o.features,
             "",
             "ORB features a picture; 0: 1000, and 2000 where it is more than a third larger than 640 x 480",
             0,
             20000,
             {}});
  table.add({"levels", &o.levels, "", "of the pyramid (Mur-Artal et al. 2015)", 1, 16, {}});
  table.add({"scale_factor", &o.scale_factor, "", "from one level to the next", 1.05, 2, {}});
  table.add({"fast_threshold", &o.fast_threshold, "grey levels", "of the corner test", 1, 255, {}});
  table.add({"least_fast_threshold",
             &o.least_fast_threshold,
             "grey levels",
             "the same where a cell has no corner by that",
             1,
             255,
             {}});
  table.add({"pixel_sigma",
             &o.pixel_sigma,
             "px",
             "standard deviation of the place of a feature of the finest level; that of others grows with the scale",
             0.05,
             20,
             {}});
}

void add_depth_options(OptionTable& table, OrbSlamOptions& o) {
  table.add(
      {"virtual_baseline_m",
       &o.virtual_baseline_m,
       "m",
       "depth z is taken for a right camera so far aside, whose pixels are as sure: sigma grows with z squared, as "
       "a depth camera's does; 0.4 at 585 px gives 4 mm at 1 m",
       0.01,
       1,
       {}});
  table.add({"far_baselines",
             &o.far_baselines,
             "",
             "depths beyond so many baselines say little: no landmark is made of one of them alone (Mur-Artal and "
             "Tardos 2017)",
             5,
             1000,
             {}});
  table.add({"start_depth_points",
             &o.start_depth_points,
             "",
             "features with depth that a map begins with, where depth is seen",
             20,
             20000,
             {}});
}

void add_stereo_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"stereo_hamming", &o.stereo_hamming, "bits", "by which left and right may differ", 1, 256, {}});
  table.add({"stereo_disparity_share",
             &o.stereo_disparity_share,
             "",
             "of the width, the largest disparity: nearer things are too different in both pictures",
             0.01,
             1,
             {}});
  table.add({"stereo_least_disparity_px",
             &o.stereo_least_disparity_px,
             "px",
             "less is as good as infinitely far",
             0.01,
             100,
             {}});
  table.add({"stereo_difference_ratio",
             &o.stereo_difference_ratio,
             "",
             "grey levels of left and right may differ by so many times the median of all pairs",
             0.5,
             100,
             {}});
}

void add_start_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"init_window_share",
             &o.init_window_share,
             "",
             "of the picture's width, how far a feature may move between the two frames a map begins with",
             0.01,
             1,
             {}});
  table.add({"init_hamming", &o.init_hamming, "bits", "by which two of the same may differ there", 1, 256, {}});
  table.add({"init_ratio", &o.init_ratio, "", "best to second best difference, at most (Lowe 2004)", 0.1, 1, {}});
  table.add({"init_matches", &o.init_matches, "", "pairs of features two frames must have", 8, 20000, {}});
  table.add({"init_points", &o.init_points, "", "points that must be in front of both, at its pixels", 5, 20000, {}});
  table.add({"init_parallax_deg",
             &o.init_parallax_deg,
             "deg",
             "median angle between both directions to a point: less makes depth a guess",
             0.01,
             45,
             {}});
  table.add({"init_homography_share",
             &o.init_homography_share,
             "",
             "S_H / (S_H + S_F) above which the scene is a plane (Mur-Artal et al. 2015, section IV)",
             0,
             1,
             {}});
  table.add({"init_iterations", &o.init_iterations, "", "most samples of either model", 10, 100000, {}});
  table.add({"init_frames",
             &o.init_frames,
             "",
             "frames whose features are kept until a map begins, to be followed afterwards",
             2,
             10000,
             {}});
  table.add({"init_trial_frames", &o.init_trial_frames, "", "in which a new map has to prove itself", 0, 1000, {}});
  table.add({"init_max_error",
             &o.init_max_error,
             "",
             "mean squared error of a frame's points, squared sigmas, of which three in a row make a new map a wrong "
             "one, which begins anew; about 0.5 where all is well",
             0.1,
             100,
             {}});
}

void add_frontend_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"frontend",
             &o.frontend,
             "",
             "how points are found again from one frame to the next: by their looks where they are expected, or by "
             "tracks that survive occlusion (Galardi et al.)",
             0,
             0,
             {"orb", "tracks"}});
  table.add({"tracks", &o.tracks, "", "features followed where frontend is tracks", 20, 20000, {}});
  table.add({"tracks_distance_px", &o.tracks_distance_px, "px", "between two of them, at least", 2, 200, {}});
  table.add({"tracks_near_px",
             &o.tracks_near_px,
             "px",
             "from a feature that shows a landmark, within which a track shows it too",
             0.1,
             20,
             {}});
  table.add({"tracks_kept", &o.tracks_kept, "", "newest tracks whose landmarks are remembered", 100, 100000000, {}});
}

void add_tracking_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"search_px",
             &o.search_px,
             "px",
             "around where the last frame's points should be, at the finest level; wider where that fails",
             1,
             200,
             {}});
  table.add({"local_search_px", &o.local_search_px, "px", "the same once the pose is about known", 0.5, 100, {}});
  table.add({"match_hamming", &o.match_hamming, "bits", "by which a landmark's looks may differ", 1, 256, {}});
  table.add({"match_ratio", &o.match_ratio, "", "best to second best difference, at most", 0.1, 1, {}});
  table.add({"max_view_angle_deg",
             &o.max_view_angle_deg,
             "deg",
             "from which a landmark is expected to look the same, against the mean direction it was seen from",
             5,
             180,
             {}});
  table.add({"min_guess_inliers",
             &o.min_guess_inliers,
             "",
             "points of the last frame that must fit, else a wider search, then the reference keyframe",
             4,
             1000,
             {}});
  table.add({"min_inliers", &o.min_inliers, "", "landmarks that must fit, or the way is lost", 4, 1000, {}});
  table.add({"pnp_iterations", &o.pnp_iterations, "", "most samples of three points", 10, 100000, {}});
  table.add({"local_keyframes", &o.local_keyframes, "", "around the newest, whose landmarks are tracked", 2, 1000, {}});
  table.add({"local_landmarks", &o.local_landmarks, "", "at most", 100, 1000000, {}});
}

void add_keyframe_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"keyframe_frames",
             &o.keyframe_frames,
             "",
             "frames after the last keyframe from which mapping need not be idle for another",
             1,
             100000,
             {}});
  table.add({"keyframe_share",
             &o.keyframe_share,
             "",
             "of the reference keyframe's landmarks: fewer tracked makes a keyframe",
             0.05,
             1,
             {}});
  table.add({"keyframe_share_depth",
             &o.keyframe_share_depth,
             "",
             "the same where depth is seen: a keyframe brings all its landmarks at once",
             0.05,
             1,
             {}});
  table.add({"keyframe_few_points",
             &o.keyframe_few_points,
             "",
             "landmarks, of which fewer tracked make a keyframe where depth shows many new ones",
             0,
             10000,
             {}});
  table.add({"keyframe_new_points", &o.keyframe_new_points, "", "features with depth that are many", 1, 10000, {}});
  table.add({"backend_delay_frames",
             &o.backend_delay_frames,
             "",
             "so many frames later, at least, tracking learns what mapping made of a keyframe, and ...",
             1,
             1000,
             {}});
  table.add({"backend_delay_s",
             &o.backend_delay_s,
             "s",
             "... so much later: the time mapping has beside it. 0.18 is four frames of 20 Hz",
             0,
             60,
             {}});
}

void add_mapping_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"cull_found_share",
             &o.cull_found_share,
             "",
             "of the frames that should see a new landmark, that must find it",
             0,
             1,
             {}});
  table.add(
      {"cull_keyframes", &o.cull_keyframes, "", "keyframes after which a landmark has proved itself", 1, 100, {}});
  table.add({"triangulate_neighbours",
             &o.triangulate_neighbours,
             "",
             "covisible keyframes that new landmarks are made with and fused with",
             1,
             200,
             {}});
  table.add(
      {"triangulate_hamming", &o.triangulate_hamming, "bits", "by which a new landmark's two may differ", 1, 256, {}});
  table.add({"triangulate_parallax_deg",
             &o.triangulate_parallax_deg,
             "deg",
             "least angle between both directions to a new landmark",
             0.01,
             45,
             {}});
  table.add({"epipolar_chi2",
             &o.epipolar_chi2,
             "",
             "squared sigmas from the epipolar line: 95 % with one degree of freedom",
             0.1,
             100,
             {}});
  table.add(
      {"fuse_px", &o.fuse_px, "px", "around where a landmark should be, for another to be the same", 0.5, 50, {}});
}

void add_adjustment_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"adjust_keyframes", &o.adjust_keyframes, "", "covisible keyframes that each new one moves", 1, 1000, {}});
  table.add({"adjust_fixed",
             &o.adjust_fixed,
             "",
             "keyframes that see the same landmarks, at most, which hold them in place",
             1,
             1000,
             {}});
  table.add({"adjust_iterations", &o.adjust_iterations, "", "of bundle adjustment, at most", 1, 1000, {}});
  table.add({"final_iterations",
             &o.final_iterations,
             "",
             "of bundle adjustment of the whole map at the end; 0: none",
             0,
             1000,
             {}});
  table.add({"final_keyframes",
             &o.final_keyframes,
             "",
             "of a larger map it is left out, so that a run ends at once",
             0,
             1000000,
             {}});
  table.add({"cull_seen_share",
             &o.cull_seen_share,
             "",
             "of its landmarks that three others see as finely: the keyframe goes",
             0.1,
             1,
             {}});
  table.add({"covisible_landmarks", &o.covisible_landmarks, "", "that make two keyframes covisible", 1, 1000, {}});
}

void add_loss_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"lost_frames",
             &o.lost_frames,
             "",
             "frames in which nothing known was seen before a new submap is begun",
             1,
             1000000,
             {}});
  table.add({"settled_frames", &o.settled_frames, "", "after relocalisation before a keyframe is made", 0, 10000, {}});
  table.add({"seed", &o.seed, "", "of everything that is drawn at random", 0, 0, {}});
}

void add_place_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"loop_closing",
             &o.loop_closing,
             "",
             "find places again, correct the map and join submaps; false: only lost frames are looked for",
             0,
             1,
             {}});
  table.add({"essential_landmarks",
             &o.essential_landmarks,
             "",
             "shared by two keyframes, that make the graph a loop bends hold them together",
             15,
             10000,
             {}});
  table.add({"place_shared_words",
             &o.place_shared_words,
             "",
             "of the words that the likest place shares, that another must",
             0,
             1,
             {}});
  table.add({"place_candidates",
             &o.place_candidates,
             "",
             "places, likest first, that are compared feature by feature",
             1,
             1000,
             {}});
  table.add({"place_hamming", &o.place_hamming, "", "bits in which features of one place may differ", 1, 256, {}});
  table.add({"place_ratio", &o.place_ratio, "", "of the bits by which the second best may differ", 0.1, 1, {}});
  table.add({"relocalise_matches",
             &o.relocalise_matches,
             "",
             "features a lost frame and a keyframe must share to be tried",
             4,
             10000,
             {}});
  table.add({"relocalise_search_px",
             &o.relocalise_search_px,
             "px",
             "around where the first pose expects a landmark, at the finest level",
             0.5,
             100,
             {}});
}

void add_loop_options(OptionTable& table, OrbSlamOptions& o) {
  table.add({"loop_neighbour_landmarks",
             &o.loop_neighbour_landmarks,
             "",
             "shared by neighbours, of which a place must be likelier than the least like",
             1,
             10000,
             {}});
  table.add({"loop_consistent",
             &o.loop_consistent,
             "",
             "keyframes in a row that must recognise the same surroundings",
             1,
             100,
             {}});
  table.add({"loop_inliers", &o.loop_inliers, "", "pairs of landmarks that must fit one similarity", 4, 10000, {}});
  table.add(
      {"loop_landmarks", &o.loop_landmarks, "", "of a place that must be found again in the keyframe", 4, 10000, {}});
  table.add({"loop_search_px",
             &o.loop_search_px,
             "px",
             "around where a similarity expects a landmark, at the finest level",
             0.5,
             100,
             {}});
  table.add({"loop_apart", &o.loop_apart, "", "keyframes after a loop before another is looked for", 0, 100000, {}});
  table.add({"loop_adjust_iterations",
             &o.loop_adjust_iterations,
             "",
             "of bundle adjustment of all after a loop, at most",
             0,
             1000,
             {}});
  table.add({"loop_adjust_delay_s",
             &o.loop_adjust_delay_s,
             "s",
             "after a loop until the map as adjusted is taken over, for each 100000 observations; earlier, tracking "
             "waits for it; later, it is older than it need be",
             0,
             1000,
             {}});
}

}  // namespace

OptionTable option_table(OrbSlamOptions& options) {
  OptionTable table;
  add_feature_options(table, options);
  add_depth_options(table, options);
  add_stereo_options(table, options);
  add_start_options(table, options);
  add_frontend_options(table, options);
  add_tracking_options(table, options);
  add_keyframe_options(table, options);
  add_mapping_options(table, options);
  add_adjustment_options(table, options);
  add_loss_options(table, options);
  add_place_options(table, options);
  add_loop_options(table, options);
  add_options(table, options.frame_check);
  return table;
}

}  // namespace rastro
