// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/fusion/options.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace rastro {
namespace {

/// Of a map that one camera starts.
constexpr std::array<std::string_view, 12> not_used = {"sensor",          "init_window_share",     "init_ratio",
                                                       "init_matches",    "init_points",           "init_parallax_deg",
                                                       "init_iterations", "init_homography_share", "init_trial_frames",
                                                       "init_max_error",  "keyframe_share",        "scale_drift_share"};

void add_depth_options(OptionTable& table, FusionOptions& o) {
  table.add({"sensor",
             &o.sensor,
             "",
             "auto: depth where the recording has it, else the stereo pair; to localize in a map also one camera",
             0,
             0,
             {"auto", "rgbd", "stereo"}});
  table.add(
      {"depth_sigma_m", &o.depth_sigma_m, "m", "part of the depth noise that does not grow with depth", 0, 1, {}});
  table.add({"depth_sigma_per_m2",
             &o.depth_sigma_per_m2,
             "1/m",
             "the depth noise is depth_sigma_m + this * depth^2; of a stereo pair both follow from stereo_sigma_px",
             0,
             1,
             {}});
  table.add({"min_depth_m", &o.min_depth_m, "m", "minimum depth aligned by", 0, 100, {}});
  table.add({"max_depth_m", &o.max_depth_m, "m", "maximum depth aligned by", 0.1, 1000, {}});
  table.add({"stereo_sigma_px", &o.stereo_sigma_px, "px", "standard deviation of a disparity", 0.01, 10, {}});
  table.add(
      {"stereo_min_disparity_px", &o.stereo_min_disparity_px, "px", "smallest disparity aligned by", 0.5, 100, {}});
  table.add({"stereo_max_disparity_px",
             &o.stereo_max_disparity_px,
             "px",
             "largest disparity searched for in keyframes, and time grows with it",
             16,
             512,
             {}});
}

void add_direct_options(OptionTable& table, FusionOptions& o) {
  table.add({"direct_points",
             &o.direct_points,
             "",
             "pixels of a keyframe with a depth and a gradient, at most, that frames are aligned by",
             100,
             100000,
             {}});
  table.add({"intensity_sigma",
             &o.intensity_sigma,
             "levels",
             "standard deviation of an intensity: noise, interpolation and what the model misses",
             0.1,
             50,
             {}});
  table.add({"surface_weight",
             &o.surface_weight,
             "",
             "of each block of depth in an alignment: the errors of neighbors are correlated",
             0,
             1,
             {}});
  table.add(
      {"most_disagreement",
       &o.most_disagreement,
       "",
       "squared sigmas per degree of freedom by which surfaces may move the pose by intensities; beyond, depth and "
       "color are not registered, and the surfaces do not count",
       0,
       1e6,
       {}});
  table.add({"disagreement_share",
             &o.disagreement_share,
             "",
             "share of the squared disagreement that is added to the variances of the pose by intensities then",
             0,
             10,
             {}});
  table.add({"trusted_alike",
             &o.trusted_alike,
             "",
             "share of the image's regions that must look like the keyframe's, for an alignment to count",
             0,
             1,
             {}});
  table.add({"common_sigma_m",
             &o.common_sigma_m,
             "m",
             "error of an alignment that all its pixels have in common, as from lens and clocks",
             0,
             1,
             {}});
  table.add({"common_sigma_rad", &o.common_sigma_rad, "rad", "the same of the rotation", 0, 1, {}});
}

}  // namespace

OptionTable option_table(FusionOptions& options) {
  OptionTable table;
  add_depth_options(table, options);
  add_direct_options(table, options);
  const OptionTable orb = option_table(options.orb);
  for (const Option& option : orb.options())
    if (std::find(not_used.begin(), not_used.end(), option.name) == not_used.end()) table.add(option);
  return table;
}

}  // namespace rastro
