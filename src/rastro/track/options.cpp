// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/options.h"

namespace rastro {
namespace {

void add_method_options(OptionTable& table, TrackOptions& o) {
  table.add({"mode",
             &o.mode,
             "",
             "klt: optical flow only; vote: one candidate by single vote; dual: the runner-up is tried too; priority: "
             "each frame proposes its best two as well (the paper's method)",
             0,
             0,
             {"klt", "vote", "dual", "priority"}});
  table.add({"features", &o.features, "", "features held in a frame; 150 as in the paper", 1, 20000, {}});
  table.add({"min_distance_px",
             &o.min_distance_px,
             "px",
             "least distance between features; 30 as in VINS-Fusion",
             1,
             500,
             {}});
  table.add({"window", &o.window, "frames", "how long a lost feature can come back; 30 as in the paper", 1, 1000, {}});
  table.add({"seed", &o.seed, "", "of every random draw: RANSAC samples, BRIEF's pattern", 0, 9.0e15, {}});
  table.add(
      {"equalise", &o.equalise, "", "equalise each image's histogram first; for dark or flat recordings", 0, 1, {}});
}

void add_flow_options(OptionTable& table, TrackOptions& o) {
  table.add(
      {"flow_window_px", &o.flow_window_px, "px", "side of the patch followed, odd; 21 as in VINS-Fusion", 5, 31, {}});
  table.add({"flow_levels", &o.flow_levels, "", "pyramid levels; 4 follow motions of about 80 px a frame", 1, 8, {}});
  table.add({"flow_iterations", &o.flow_iterations, "", "most steps on a level", 1, 200, {}});
  table.add({"flow_epsilon_px", &o.flow_epsilon_px, "px", "a smaller step ends the finest level", 1e-4, 1, {}});
  table.add({"flow_coarse_epsilon_px",
             &o.flow_coarse_epsilon_px,
             "px",
             "as flow_epsilon_px, for the coarser levels, in their own pixels; the next level refines what they leave",
             1e-4,
             1,
             {}});
}

void add_flow_check_options(OptionTable& table, TrackOptions& o) {
  table.add({"max_backward_px",
             &o.max_backward_px,
             "px",
             "a feature followed back must end this near to where it was; 0.5 as in VINS-Fusion",
             0.01,
             50,
             {}});
  table.add({"max_residual_ratio",
             &o.max_residual_ratio,
             "",
             "squared brightness difference left after following, as share of the patch's variance; more means that "
             "something else came in front",
             0.01,
             100,
             {}});
  table.add({"min_texture",
             &o.min_texture,
             "(grey/px)^2",
             "least mean squared gradient of a patch in its weakest direction; at 0.1 noise of 2 grey levels already "
             "moves a 21 px patch by 0.3 px",
             0,
             1e4,
             {}});
  table.add({"reference_interval",
             &o.reference_interval,
             "frames",
             "how often a followed feature's look is kept anew, to be compared and aligned with later",
             1,
             1000,
             {}});
  table.add({"max_reference_residual",
             &o.max_reference_residual,
             "",
             "as max_residual_ratio, against the look kept before the last: finds features that slide slowly onto "
             "something in front. 0: no such check, the paper's way",
             0,
             1e6,
             {}});
  table.add({"max_epipolar_error_px",
             &o.max_epipolar_error_px,
             "px",
             "features that move against the fundamental matrix of two frames by more are dropped; 1 as in VINS-Fusion",
             0.05,
             100,
             {}});
}

void add_corner_options(OptionTable& table, TrackOptions& o) {
  table.add({"corner_quality",
             &o.corner_quality,
             "",
             "least corner score as share of the frame's best (Shi and Tomasi)",
             1e-6,
             1,
             {}});
  table.add({"corner_border_px", &o.corner_border_px, "px", "no corner nearer to the edge", 1, 200, {}});
}

void add_candidate_options(OptionTable& table, TrackOptions& o) {
  table.add({"verify_corners",
             &o.verify_corners,
             "",
             "a corner gets a new id only if it can be followed back to the last frame, as the crossing of an edge "
             "with a nearer one cannot, and not where a feature has just been lost; false: the paper's way",
             0,
             1,
             {}});
  table.add({"candidates_factor",
             &o.candidates_factor,
             "",
             "corners looked at for recognition, as multiple of those needed; recognised ones are taken first. 1 is "
             "the paper's way",
             1,
             20,
             {}});
  table.add({"max_candidates_factor",
             &o.max_candidates_factor,
             "",
             "corners looked at for recognition at most, as multiple of features: bounds the time of a frame in which "
             "all was lost",
             1,
             100,
             {}});
  table.add({"candidates_distance_px",
             &o.candidates_distance_px,
             "px",
             "least distance between the corners looked at; 0: min_distance_px, the paper's way",
             0,
             500,
             {}});
  table.add({"displace",
             &o.displace,
             "",
             "in a full frame a recognised feature takes the place of the youngest one, if that is younger: finds some "
             "more again, a few of them wrongly, and costs time; false is the paper's way",
             0,
             1,
             {}});
}

void add_descriptor_options(OptionTable& table, TrackOptions& o) {
  table.add({"brief_patch_px", &o.brief_patch_px, "px", "side of the patch BRIEF's tests are drawn in", 8, 64, {}});
  table.add({"brief_smoothing_px",
             &o.brief_smoothing_px,
             "px",
             "side of the box that smooths before BRIEF, odd; 9 as in Calonder et al. 2010",
             1,
             15,
             {}});
  table.add({"descriptor",
             &o.descriptor,
             "",
             "upright: BRIEF as published; steered: turned by the patch's orientation; scaled: compared at several "
             "scales; steered_scaled: both",
             0,
             0,
             {"upright", "steered", "scaled", "steered_scaled"}});
  table.add({"max_hamming",
             &o.max_hamming,
             "bits",
             "descriptors that differ in more of their 256 bits are not alike",
             0,
             256,
             {}});
  table.add({"min_votes", &o.min_votes, "frames", "window frames that must propose an id", 1, 1000, {}});
}

void add_alignment_options(OptionTable& table, TrackOptions& o) {
  table.add({"foresee",
             &o.foresee,
             "",
             "lost features are looked for where the motion of the others puts them, turned and scaled by it, before "
             "corners are detected; false: only at corners, the paper's way",
             0,
             1,
             {}});
  table.add({"align",
             &o.align,
             "",
             "a recognised corner must look like the lost feature did and is put where it does, by optical flow from "
             "the look kept; false: the paper's way",
             0,
             1,
             {}});
  table.add({"look_window_px", &o.look_window_px, "px", "side of the patch kept of a feature's look, odd", 5, 31, {}});
  table.add({"max_alignment_px",
             &o.max_alignment_px,
             "px",
             "how far the alignment may move a recognised corner",
             0.1,
             20,
             {}});
  table.add({"max_alignment_residual",
             &o.max_alignment_residual,
             "",
             "as max_residual_ratio, of a recognised corner against the look kept",
             0.01,
             1e6,
             {}});
  table.add({"min_alignment_texture",
             &o.min_alignment_texture,
             "(grey/px)^2",
             "as min_texture, for what a recognised corner is aligned with",
             0,
             1e4,
             {}});
  table.add({"max_travel_px",
             &o.max_travel_px,
             "px",
             "corners farther from a lost feature's last place, and from that place moved by the median of the "
             "features followed since, are not compared with it; 0: all are, the paper's way",
             0,
             1e5,
             {}});
}

void add_validation_options(OptionTable& table, TrackOptions& o) {
  table.add({"validation",
             &o.validation,
             "",
             "homography: one plane or rotation, the paper's; epipolar: fundamental matrix, for scenes with depth; "
             "local: motion of the nearest features",
             0,
             0,
             {"homography", "epipolar", "local"}});
  table.add({"max_reprojection_px",
             &o.max_reprojection_px,
             "px",
             "a recognised corner may lie this far from where the motion puts it",
             0.1,
             100,
             {}});
  table.add({"min_inliers",
             &o.min_inliers,
             "",
             "features that must agree on a motion before it may confirm anything",
             4,
             1000,
             {}});
  table.add({"min_inlier_share",
             &o.min_inlier_share,
             "",
             "of the features shared with a window frame, how many a homography must explain to be believed alone; "
             "below, the nearest features must agree as well. 0: always believed, the paper's way",
             0,
             1,
             {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "most samples drawn for one motion", 1, 100000, {}});
}

}  // namespace

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
