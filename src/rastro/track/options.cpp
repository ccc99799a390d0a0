// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/options.h"

namespace rastro {
namespace {

void add_method_options(OptionTable& table, TrackOptions& o) {
  table.add(
      {"mode",
       &o.mode,
       "",
       "klt: optical flow only; vote: one candidate by single voting; dual: the runner-up is tried too; priority: "
       "each frame also proposes its best two (as in the paper)",
       0,
       0,
       {"klt", "vote", "dual", "priority"}});
  table.add({"features", &o.features, "", "number of features in a frame; 150 as in the paper", 1, 20000, {}});
  table.add({"min_distance_px",
             &o.min_distance_px,
             "px",
             "minimum distance between features; 30 as in VINS-Fusion",
             1,
             500,
             {}});
  table.add({"window",
             &o.window,
             "frames",
             "number of frames for which a lost feature can be re-identified; 30 as in the paper",
             1,
             1000,
             {}});
  table.add({"seed", &o.seed, "", "seed of the random numbers: RANSAC samples, BRIEF's pattern", 0, 9.0e15, {}});
  table.add(
      {"equalize", &o.equalize, "", "equalize each image's histogram first; for dark or flat recordings", 0, 1, {}});
  table.add_former_name("equalise", "equalize");
}

void add_flow_options(OptionTable& table, TrackOptions& o) {
  table.add(
      {"flow_window_px", &o.flow_window_px, "px", "side of the patch tracked, odd; 21 as in VINS-Fusion", 5, 31, {}});
  table.add({"flow_levels", &o.flow_levels, "", "pyramid levels; 4 track motions of about 80 px per frame", 1, 8, {}});
  table.add({"flow_iterations", &o.flow_iterations, "", "iterations per level, at most", 1, 200, {}});
  table.add({"flow_epsilon_px", &o.flow_epsilon_px, "px", "a smaller step ends the finest level", 1e-4, 1, {}});
  table.add({"flow_coarse_epsilon_px",
             &o.flow_coarse_epsilon_px,
             "px",
             "as flow_epsilon_px, for the coarser levels, in their own pixels; the next level refines the result",
             1e-4,
             1,
             {}});
}

void add_flow_check_options(OptionTable& table, TrackOptions& o) {
  table.add({"max_backward_px",
             &o.max_backward_px,
             "px",
             "maximum forward-backward error; 0.5 as in VINS-Fusion",
             0.01,
             50,
             {}});
  table.add({"max_residual_ratio",
             &o.max_residual_ratio,
             "",
             "maximum squared intensity residual after tracking, as share of the patch's variance; more means that "
             "the feature is occluded",
             0.01,
             100,
             {}});
  table.add({"min_texture",
             &o.min_texture,
             "(intensity/px)^2",
             "minimum mean squared gradient of a patch in its weakest direction; at 0.1, intensity noise of 2 already "
             "moves a 21 px patch by 0.3 px",
             0,
             1e4,
             {}});
  table.add({"reference_interval",
             &o.reference_interval,
             "frames",
             "interval at which a tracked feature's patch is stored, for later comparison and alignment",
             1,
             1000,
             {}});
  table.add({"max_reference_residual",
             &o.max_reference_residual,
             "",
             "as max_residual_ratio, against the patch stored before the last: finds features that slide slowly onto "
             "an occluder. 0: no check, as in the paper",
             0,
             1e6,
             {}});
  table.add({"max_epipolar_error_px",
             &o.max_epipolar_error_px,
             "px",
             "maximum epipolar error to the fundamental matrix of two frames; 1 as in VINS-Fusion",
             0.05,
             100,
             {}});
}

void add_corner_options(OptionTable& table, TrackOptions& o) {
  table.add({"corner_quality",
             &o.corner_quality,
             "",
             "minimum corner score as share of the frame's best (Shi and Tomasi)",
             1e-6,
             1,
             {}});
  table.add({"corner_border_px", &o.corner_border_px, "px", "minimum distance of corners from the edge", 1, 200, {}});
}

void add_candidate_options(OptionTable& table, TrackOptions& o) {
  table.add({"verify_corners",
             &o.verify_corners,
             "",
             "a corner gets a new id only if it can be tracked back to the previous frame, as the crossing of an edge "
             "with a nearer one cannot, and not where a feature was just lost; false: as in the paper",
             0,
             1,
             {}});
  table.add({"candidates_factor",
             &o.candidates_factor,
             "",
             "corners tried for re-identification, as multiple of those needed; re-identified ones are taken first. 1: "
             "as in the paper",
             1,
             20,
             {}});
  table.add(
      {"max_candidates_factor",
       &o.max_candidates_factor,
       "",
       "corners tried for re-identification at most, as multiple of features: bounds the time of a frame in which "
       "all features were lost",
       1,
       100,
       {}});
  table.add({"candidates_distance_px",
             &o.candidates_distance_px,
             "px",
             "minimum distance between the corners tried for re-identification; 0: min_distance_px, as in the paper",
             0,
             500,
             {}});
  table.add(
      {"displace",
       &o.displace,
       "",
       "in a full frame a re-identified feature replaces the youngest one, if that is younger: re-identifies some "
       "more, a few of them wrongly, and costs time; false: as in the paper",
       0,
       1,
       {}});
}

void add_descriptor_options(OptionTable& table, TrackOptions& o) {
  table.add({"brief_patch_px", &o.brief_patch_px, "px", "side of the patch of BRIEF's tests", 8, 64, {}});
  table.add({"brief_smoothing_px",
             &o.brief_smoothing_px,
             "px",
             "side of the box filter before BRIEF, odd; 9 as in Calonder et al. 2010",
             1,
             15,
             {}});
  table.add({"descriptor",
             &o.descriptor,
             "",
             "upright: BRIEF as published; steered: rotated by the patch's orientation; scaled: compared at several "
             "scales; steered_scaled: both",
             0,
             0,
             {"upright", "steered", "scaled", "steered_scaled"}});
  table.add({"max_hamming", &o.max_hamming, "bits", "maximum Hamming distance of a match, of 256 bits", 0, 256, {}});
  table.add({"min_votes", &o.min_votes, "frames", "window frames that must propose an id", 1, 1000, {}});
}

void add_alignment_options(OptionTable& table, TrackOptions& o) {
  table.add(
      {"predict",
       &o.predict,
       "",
       "lost features are searched at their positions predicted from the others' motion, rotated and scaled, before "
       "corners are detected; false: only at corners, as in the paper",
       0,
       1,
       {}});
  table.add(
      {"align",
       &o.align,
       "",
       "a re-identified corner must match the lost feature's stored patch and is aligned with it by optical flow; "
       "false: as in the paper",
       0,
       1,
       {}});
  table.add({"patch_window_px", &o.patch_window_px, "px", "side of a feature's stored patch, odd", 5, 31, {}});
  table.add({"max_alignment_px",
             &o.max_alignment_px,
             "px",
             "maximum shift of a re-identified corner by the alignment",
             0.1,
             20,
             {}});
  table.add({"max_alignment_residual",
             &o.max_alignment_residual,
             "",
             "as max_residual_ratio, of a re-identified corner against the stored patch",
             0.01,
             1e6,
             {}});
  table.add({"min_alignment_texture",
             &o.min_alignment_texture,
             "(intensity/px)^2",
             "as min_texture, for the stored patch of the alignment",
             0,
             1e4,
             {}});
  table.add({"max_travel_px",
             &o.max_travel_px,
             "px",
             "corners farther from a lost feature's last position, and from that position moved by the median of the "
             "features tracked since, are not compared with it; 0: all are, as in the paper",
             0,
             1e5,
             {}});
  table.add_former_name("foresee", "predict");
  table.add_former_name("look_window_px", "patch_window_px");
}

void add_validation_options(OptionTable& table, TrackOptions& o) {
  table.add({"validation",
             &o.validation,
             "",
             "homography: one plane or rotation, as in the paper; epipolar: fundamental matrix, for scenes with depth; "
             "local: motion of the nearest features",
             0,
             0,
             {"homography", "epipolar", "local"}});
  table.add({"max_reprojection_px",
             &o.max_reprojection_px,
             "px",
             "maximum error of a re-identified corner to its predicted position",
             0.1,
             100,
             {}});
  table.add(
      {"min_inliers", &o.min_inliers, "", "inliers that a motion needs before it may confirm anything", 4, 1000, {}});
  table.add({"min_inlier_share",
             &o.min_inlier_share,
             "",
             "share of inliers, among the features shared with a window frame, for a homography to suffice alone; "
             "below, the nearest features must agree as well. 0: it always suffices, as in the paper",
             0,
             1,
             {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "RANSAC iterations, at most", 1, 100000, {}});
}

}  // namespace

std::vector<std::string> track_presets() { return {"paper"}; }

void set_paper_preset(TrackOptions& options) {
  options.predict = false;
  options.candidates_factor = 1.0;
  options.candidates_distance_px = 0.0;
  options.verify_corners = false;
  options.align = false;
  options.min_inlier_share = 0.0;
  options.max_travel_px = 0.0;
  options.max_reference_residual = 0.0;
  options.max_residual_ratio = 100.0;
  options.max_reprojection_px = 3.0;
  options.max_epipolar_error_px = 1.0;
  options.ransac_iterations = 200;
}

OptionTable option_table(TrackOptions& options) {
  OptionTable table;
  add_method_options(table, options);
  add_flow_options(table, options);
  add_flow_check_options(table, options);
  add_corner_options(table, options);
  add_candidate_options(table, options);
  add_descriptor_options(table, options);
  add_alignment_options(table, options);
  add_validation_options(table, options);
  return table;
}

}  // namespace rastro
