// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rtabmap/options.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace rastro {
namespace {

/// Of the search for loops by chance, which place recognition replaces; words are binary.
constexpr std::array<std::string_view, 5> not_used = {"descriptor", "random_candidates", "join_candidates",
                                                      "relocalize_random", "memory_reserve_mb"};

void add_sensor_options(OptionTable& table, RtabmapOptions& o) {
  table.add({"sensor",
             &o.sensor,
             "",
             "auto: depth where the recording has it, else the stereo pair",
             0,
             0,
             {"auto", "rgbd", "stereo"}});
  table.add({"stereo_sigma_px",
             &o.stereo_sigma_px,
             "px",
             "standard deviation of a disparity; with a stereo pair, depth_sigma_m and depth_sigma_per_m2 follow, and "
             "surfaces are off, where left at their defaults",
             0.01,
             10,
             {}});
  table.add({"stereo_min_disparity_px",
             &o.stereo_min_disparity_px,
             "px",
             "smallest disparity used; with a stereo pair, max_depth_m follows where left at its default",
             0.5,
             100,
             {}});
  table.add({"stereo_max_disparity_px",
             &o.stereo_max_disparity_px,
             "px",
             "largest disparity searched for: nearer points have no depth, and time grows with it; with a stereo pair, "
             "min_depth_m follows where left at its default",
             16,
             512,
             {}});
}

void add_word_options(OptionTable& table, RtabmapOptions& o) {
  table.add({"distance_ratio",
             &o.distance_ratio,
             "",
             "a feature becomes a new word unless its nearest word is closer than this share of the second nearest",
             0.1,
             1,
             {}});
  table.add({"words_per_image",
             &o.words_per_image,
             "",
             "strongest features of a keyframe that become words of the incremental vocabulary",
             10,
             5000,
             {}});
  table.add({"bad_signature",
             &o.bad_signature,
             "",
             "a keyframe with fewer features than this share of the mean closes no loop by its words (T_bad)",
             0,
             1,
             {}});
}

void add_memory_options(OptionTable& table, RtabmapOptions& o) {
  table.add({"short_term_size",
             &o.short_term_size,
             "",
             "latest locations in which no loop is looked for (T_stm)",
             1,
             10000,
             {}});
  table.add({"rehearsal_similarity",
             &o.rehearsal_similarity,
             "",
             "share of common words from which a keyframe adds weight to the last location instead of beginning "
             "another one (T_rehearsal)",
             0,
             1,
             {}});
  table.add({"time_limit_ms",
             &o.time_limit_ms,
             "ms",
             "locations move to long-term memory when words and Bayes filter of one keyframe took longer (T_time); by "
             "the clock in live runs, else by counted work, so that every run does the same",
             0,
             1e6,
             {}});
  table.add({"retrieved_neighbors",
             &o.retrieved_neighbors,
             "",
             "neighbors of likely locations that come back from long-term memory with each keyframe",
             0,
             100,
             {}});
  table.add({"memory_reserve_mb",
             &o.rgbd.memory_reserve_mb,
             "MB",
             "part of --max-memory reserved for everything but the features of working memory and what places are "
             "recognized by",
             0,
             1e6,
             {}});
}

void add_filter_options(OptionTable& table, RtabmapOptions& o) {
  table.add({"loop_probability",
             &o.loop_probability,
             "",
             "probability from which a location is compared with the keyframe (T_loop)",
             0,
             1,
             {}});
  table.add({"stays_new",
             &o.stays_new,
             "",
             "Bayes filter: probability that a new place is followed by another one",
             0,
             1,
             {}});
  table.add({"neighbor_sigma",
             &o.neighbor_sigma,
             "links",
             "Bayes filter: standard deviation of the motion between two keyframes",
             0.1,
             20,
             {}});
  table.add({"hypotheses", &o.hypotheses, "", "likely locations compared with each keyframe", 0, 100, {}});
}

void add_index_options(OptionTable& table, RtabmapOptions& o) {
  table.add({"similar_locations",
             &o.similar_locations,
             "",
             "locations of all memory, long-term memory included, that are compared because words of the fixed "
             "vocabulary say that they look alike; 0: only working memory is searched, as in the paper",
             0,
             100,
             {}});
  table.add({"least_similarity",
             &o.least_similarity,
             "",
             "similarity that these need, relative to that of the previous location",
             0,
             1,
             {}});
}

}  // namespace

RtabmapOptions::RtabmapOptions() {
  rgbd.random_candidates = 0;
  rgbd.join_candidates = 0;
  rgbd.relocalize_random = 0;
  rgbd.lost_frames = 15;
  rgbd.lost_s = 0.5;
  rgbd.descriptor = "even_orb";
  rgbd.min_alike = 0.87;
  rgbd.loop_drift_share = 0.05;
  rgbd.loop_drift_rad_per_m = 0.01;
  rgbd.loop_inliers = 20;
  rgbd.relocalize_inliers = 22;
}

void set_paper_preset(RtabmapOptions& options) {
  options.words_per_image = 400;
  options.time_limit_ms = 700.0;
  options.hypotheses = 1;
  options.similar_locations = 0;
  options.rgbd.min_alike = 0.0;
  options.rgbd.loop_inliers = 25;
  options.rgbd.match_far = false;
  options.rgbd.relocalize_inliers = 30;
  options.rgbd.near_candidates = 0;
  options.rgbd.graph_candidates = 0;
  options.rgbd.last_candidates = 0;
}

OptionTable option_table(RtabmapOptions& options) {
  OptionTable table;
  add_sensor_options(table, options);
  add_word_options(table, options);
  add_memory_options(table, options);
  add_filter_options(table, options);
  add_index_options(table, options);
  const OptionTable rgbd = option_table(options.rgbd);
  for (const Option& option : rgbd.options())
    if (std::find(not_used.begin(), not_used.end(), option.name) == not_used.end()) table.add(option);
  return table;
}

}  // namespace rastro
