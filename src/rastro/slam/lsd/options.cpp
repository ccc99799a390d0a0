// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/options.h"

namespace rastro {
namespace {

void add_sensor_options(OptionTable& table, LsdOptions& o) {
  table.add({"sensor",
             &o.sensor,
             "",
             "sensors to use: auto: all that the recording has (depth before a second camera), or fewer",
             0,
             0,
             {"auto", "mono", "stereo", "rgbd"}});
  table.add({"stereo_min_disparity_px",
             &o.stereo_min_disparity_px,
             "px",
             "least disparity of a pair that gives a depth: below, its error is as large as itself",
             0.1,
             100,
             {}});
  table.add({"stereo_max_disparity_px",
             &o.stereo_max_disparity_px,
             "px",
             "largest disparity of a pair that is searched: nearer points have no depth",
             4,
             900,
             {}});
  table.add(
      {"depth_sigma_m", &o.depth_sigma_m, "m", "standard deviation of a depth camera's depth, plus ...", 0, 1, {}});
  table.add({"depth_sigma_per_m2",
             &o.depth_sigma_per_m2,
             "1/m",
             "... this times the squared depth: the camera measures disparity",
             0.0001,
             1,
             {}});
  table.add(
      {"depth_edge_sigmas",
       &o.depth_edge_sigmas,
       "sigmas",
       "rms deviation from a plane, of 5x5 depths, beyond which a pixel lies at an edge and gets no depth from the "
       "camera: its intensities belong to what is nearer, its depth to either",
       0.1,
       100,
       {}});
  table.add({"min_depth_m", &o.min_depth_m, "m", "depths of a depth camera below this are not used", 0, 100, {}});
  table.add({"max_depth_m", &o.max_depth_m, "m", "depths of a depth camera beyond this are not used", 0.1, 1000, {}});
  table.add({"start_pixels",
             &o.start_pixels,
             "",
             "pixels with a measured depth that the first keyframe of a pair or a depth camera needs",
             100,
             1000000,
             {}});
}

void add_start_options(OptionTable& table, LsdOptions& o) {
  table.add({"start",
             &o.start,
             "",
             "first depths: from two views, or random ones with a large variance, the paper's: frames are weak "
             "until they have converged, which they may never do",
             0,
             0,
             {"two_views", "random"}});
  table.add({"init_parallax_deg", &o.init_parallax_deg, "deg", "median parallax that two views need", 0.1, 20, {}});
}

void add_tracking_options(OptionTable& table, LsdOptions& o) {
  table.add({"levels", &o.levels, "", "levels of the image pyramid, each half as large", 1, 8, {}});
  table.add({"max_points",
             &o.max_points,
             "",
             "pixels of a level that a frame is aligned by, evenly chosen: more take time, and add little",
             100,
             1000000,
             {}});
  table.add({"min_overlap",
             &o.min_overlap,
             "",
             "share of the keyframe's pixels that must be in view, else the frame is lost",
             0,
             1,
             {}});
  table.add({"lost_frames", &o.lost_frames, "frames", "after so many lost ones a new submap begins", 1, 100000, {}});
}

void add_belief_options(OptionTable& table, LsdOptions& o) {
  table.add(
      {"trusted_alike",
       &o.trusted_alike,
       "",
       "share of the regions of the image whose intensities must be correlated with those of the keyframe by 0.5, else "
       "the pose is lost, or the constraint refused: 0.85 and more where both show the same, 0.2 and less elsewhere",
       0,
       1,
       {}});
  table.add(
      {"max_acceleration",
       &o.max_acceleration,
       "m/s^2",
       "a pose that only a larger acceleration explains is weak, unless one camera gives no meters; 0: not checked",
       0,
       1e6,
       {}});
  table.add(
      {"trusted_regions",
       &o.trusted_regions,
       "",
       "share of the regions of the image in which most pixels must fit, else the frame is weak: something may hide "
       "the others",
       0,
       1,
       {}});
  table.add({"trusted_sigma",
             &o.trusted_sigma,
             "mean distances",
             "standard deviation of the position above which the frame is weak",
             0,
             100,
             {}});
}

void add_loss_options(OptionTable& table, LsdOptions& o) {
  table.add({"max_gain",
             &o.max_gain,
             "",
             "change of the intensities since the keyframe, as a factor or its inverse, above which the frame is lost: "
             "flat images fit everything",
             1,
             10,
             {}});
  table.add({"max_jump_deg",
             &o.max_jump_deg,
             "deg",
             "change of the view, by motion and rotation, beyond what was expected, with which a weak frame is lost",
             0,
             180,
             {}});
  table.add({"relocalize_frames",
             &o.relocalize_frames,
             "frames",
             "in a row that must agree with a relocalization; until then the pose is not believed",
             1,
             100,
             {}});
  table.add({"max_drift",
             &o.max_drift,
             "",
             "share of the path since a keyframe by which the map may have drifted: a relocalization farther away than "
             "that, and than the camera can have moved while lost, is not believed",
             0,
             1,
             {}});
  table.add({"max_scale_error",
             &o.max_scale_error,
             "",
             "standard deviation of the scale, as a share of it and beyond its drift, above which frames of one camera "
             "are weak: in fast turns, until something tells the scale again",
             0,
             1000,
             {}});
  table.add({"scale_drift_share",
             &o.scale_drift_share,
             "",
             "standard deviation of the drift of the scale from a keyframe to the next with one camera, as share, for "
             "the covariances of poses and the variances of the map's depths",
             0,
             1,
             {}});
}

void add_depth_options(OptionTable& table, LsdOptions& o) {
  table.add({"min_gradient",
             &o.min_gradient,
             "levels/px",
             "pixels with less have no depth, unless a neighbor has more",
             0.1,
             255,
             {}});
  table.add({"intensity_sigma",
             &o.intensity_sigma,
             "levels",
             "standard deviation of an image's intensities: noise, interpolation, and what no model covers",
             0.1,
             100,
             {}});
  table.add({"line_sigma_px",
             &o.line_sigma_px,
             "px",
             "standard deviation of the epipolar lines' positions, by errors of pose and calibration",
             0,
             10,
             {}});
  table.add({"disparity_sigma_px", &o.disparity_sigma_px, "px", "least standard deviation of a disparity", 0, 10, {}});
  table.add({"min_line_px",
             &o.min_line_px,
             "px",
             "shift of a pixel by its depth from which stereo says something",
             0,
             100,
             {}});
}

void add_variance_options(OptionTable& table, LsdOptions& o) {
  table.add({"common_share",
             &o.common_share,
             "",
             "share of a depth's variance from one frame that no number of further ones reduces: they err alike",
             0,
             1,
             {}});
  table.add(
      {"surface_share",
       &o.surface_share,
       "",
       "share of the squared distance to neighbors on another surface that the map adds to a depth's variance: it may "
       "belong there",
       0,
       10,
       {}});
  table.add({"max_depth_sigma",
             &o.max_depth_sigma,
             "",
             "depths less certain than this share of themselves (without surface_share) help to track but are left out "
             "of the map; 0: none is. Clouds and views leave out those less certain than 0.1 (with surface_share)",
             0,
             100,
             {}});
  table.add({"map_share",
             &o.map_share,
             "",
             "largest share of a keyframe's pixels that the map keeps, those with the most certain depths; all help to "
             "track",
             0.001,
             1,
             {}});
  table.add({"variance_growth",
             &o.variance_growth,
             "",
             "factor of a depth's variance from frame to frame: their errors are not independent",
             1,
             10,
             {}});
}

void add_keyframe_options(OptionTable& table, LsdOptions& o) {
  table.add({"keyframe_distance",
             &o.keyframe_distance,
             "",
             "motion from which a new keyframe is made, times the mean inverse depth: a share of the mean distance",
             0.01,
             10,
             {}});
  table.add({"keyframe_overlap",
             &o.keyframe_overlap,
             "",
             "share of the keyframe's pixels in view below which a new one is made",
             0,
             1,
             {}});
  table.add({"keyframe_residual",
             &o.keyframe_residual,
             "sigmas",
             "rms residual above which a frame becomes no keyframe and does not improve depths",
             0,
             100,
             {}});
  table.add({"max_motion_error",
             &o.max_motion_error,
             "",
             "standard deviation of the motion since the keyframe, as a share of it, above which a frame of one camera "
             "becomes no keyframe: the scale of what comes into view would follow from that motion",
             0,
             1000,
             {}});
  table.add(
      {"max_keyframe_scale_error",
       &o.max_keyframe_scale_error,
       "",
       "standard deviation of the scale, as a share of it and beyond its drift, above which a frame of one camera "
       "becomes no keyframe: the camera is lost for a moment rather than followed at any scale",
       0,
       1000,
       {}});
  table.add(
      {"keyframe_frames",
       &o.keyframe_frames,
       "frames",
       "that must have improved a keyframe, as tracking knows it, before one follows it as soon as keyframe_overlap is "
       "reached; before, halfway between that and min_overlap: depths are shown after two, and mapping is behind",
       0,
       100,
       {}});
}

void add_mapping_options(OptionTable& table, LsdOptions& o) {
  table.add(
      {"return_share",
       &o.return_share,
       "",
       "where a new keyframe would be made, an earlier one goes on instead if the frame is within this share of "
       "keyframe_distance and of what keyframe_overlap lets out of view: memory grows with what is seen, not with "
       "time; 0: never",
       0,
       1,
       {}});
  table.add({"earlier_frames",
             &o.earlier_frames,
             "frames",
             "right before a keyframe that give depths to it at once: what came into view since the last keyframe has "
             "none otherwise",
             0,
             10,
             {}});
  table.add(
      {"backend_delay_frames",
       &o.backend_delay_frames,
       "",
       "pipeline latency: the depths that a frame improved are used from this many frames later on, a new keyframe "
       "from the next one; 1: depths too, and tracking and mapping wait for each other. 1 and 2 are about equally "
       "exact, "
       "3 and 4 are not",
       1,
       1000,
       {}});
}

void add_constraint_options(OptionTable& table, LsdOptions& o) {
  table.add({"near_keyframes",
             &o.near_keyframes,
             "",
             "nearest keyframes that each is aligned with: of the last ten, and of earlier visits",
             0,
             100,
             {}});
  table.add({"similar_keyframes",
             &o.similar_keyframes,
             "",
             "keyframes that share most visual words and that each is aligned with: loop closures",
             0,
             100,
             {}});
  table.add(
      {"backend_direct_frames",
       &o.backend_direct_frames,
       "",
       "first frames on a keyframe whose depths are used from the next frame on: in fast turns hardly anything else "
       "is known",
       0,
       1000,
       {}});
  table.add(
      {"max_reciprocal_error",
       &o.max_reciprocal_error,
       "squared sigmas",
       "largest difference between the alignments of two keyframes with each other; four times as much where the map "
       "has the loop already",
       0,
       1e6,
       {}});
  table.add({"min_constraint_overlap",
             &o.min_constraint_overlap,
             "",
             "share of the pixels of either keyframe that must be in view of the other",
             0,
             1,
             {}});
  table.add({"loop_share",
             &o.loop_share,
             "",
             "share of the compared pixels that must fit both ways for a merge of submaps or a loop closure that moves "
             "the map; right ones have 0.88 and more, houses alike up to 0.85",
             0,
             1,
             {}});
  table.add({"optimize_iterations", &o.optimize_iterations, "", "of the pose graph, per stage", 1, 1000, {}});
}

void add_refinement_options(OptionTable& table, LsdOptions& o) {
  table.add({"refine_iterations",
             &o.refine_iterations,
             "",
             "of the photometric bundle adjustment of all keyframes at the end, at most; 0: none",
             0,
             1000,
             {}});
  table.add({"refine_points", &o.refine_points, "", "of a keyframe in it, at most", 50, 100000, {}});
  table.add(
      {"refine_targets", &o.refine_targets, "", "keyframes that each is compared with in it, at most", 1, 50, {}});
}

}  // namespace

void set_paper_preset(LsdOptions& options) {
  options.start = "random";
  options.refine_iterations = 0;
  options.max_depth_sigma = 0.0;
  options.map_share = 1.0;
}

OptionTable option_table(LsdOptions& options) {
  OptionTable table;
  table.add({"seed", &options.seed, "", "seed of the random numbers", 0, 0, {}});
  add_sensor_options(table, options);
  add_start_options(table, options);
  add_tracking_options(table, options);
  add_belief_options(table, options);
  add_loss_options(table, options);
  add_depth_options(table, options);
  add_variance_options(table, options);
  add_keyframe_options(table, options);
  add_mapping_options(table, options);
  add_constraint_options(table, options);
  add_refinement_options(table, options);
  add_options(table, options.frame_check);
  return table;
}

}  // namespace rastro
