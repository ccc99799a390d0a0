// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <span>
#include <string>

#include "place_testing.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// Expected reason of a corrupt frame, by method; a method that is not named does not use the corrupt data.
using SaidBy = std::map<std::string, SlamReason>;

/// One bad frame in place of, or between, good ones.
struct Hostile {
  const char* what;
  void (*spoil)(Frame& frame);
  SaidBy said;
};

inline const SaidBy said_few_returns = {{"ekf", SlamReason::few_returns}, {"hector", SlamReason::few_returns}};
inline const SaidBy said_dark = {{"fusion", SlamReason::dark_or_blank},
                                 {"orb", SlamReason::dark_or_blank},
                                 {"rgbd", SlamReason::dark_or_blank},
                                 {"rtabmap", SlamReason::dark_or_blank},
                                 {"lsd", SlamReason::dark_or_blank}};

inline LaserScan& scan_of(Frame& frame) { return *frame.scan; }
inline void fill(Frame& frame, float range) {
  std::fill(scan_of(frame).ranges.begin(), scan_of(frame).ranges.end(), range);
}

inline const Hostile spoilt_scans[] = {
    {"nothing at all",
     [](Frame& frame) {
       Frame bare;
       bare.index = frame.index;
       bare.stamp = frame.stamp;
       frame = bare;
     },
     {{"ekf", SlamReason::no_odometry}, {"hector", SlamReason::no_data}}},
    {"no odometry", [](Frame& frame) { frame.odometry_from_body.reset(); }, {{"ekf", SlamReason::no_odometry}}},
    {"no scan and no observations",
     [](Frame& frame) {
       frame.scan.reset();
       frame.landmarks.clear();
     },
     {{"ekf", SlamReason::no_data}, {"hector", SlamReason::no_data}}},
    {"a black image and nothing else",
     [](Frame& frame) {
       frame.scan.reset();
       frame.landmarks.clear();
       frame.image = GrayImage(64, 48);
     },
     {{"ekf", SlamReason::no_data}, {"hector", SlamReason::no_data}}},
    {"an empty scan", [](Frame& frame) { scan_of(frame).ranges.clear(); }, said_few_returns},
    {"one beam", [](Frame& frame) { scan_of(frame).ranges.resize(1); }, said_few_returns},
    {"beams that are no number", [](Frame& frame) { fill(frame, std::numeric_limits<float>::quiet_NaN()); },
     said_few_returns},
    {"endless beams", [](Frame& frame) { fill(frame, std::numeric_limits<float>::infinity()); }, said_few_returns},
    {"negative endless beams", [](Frame& frame) { fill(frame, -std::numeric_limits<float>::infinity()); },
     said_few_returns},
    {"beams of no length", [](Frame& frame) { fill(frame, 0.0F); }, said_few_returns},
    {"free beams", [](Frame& frame) { fill(frame, 1e9F); }, said_few_returns},
    {"all beams in one direction",
     [](Frame& frame) { scan_of(frame).angle_step = 0.0; },
     {{"hector", SlamReason::degenerate}}},
    {"observations of zero range",
     [](Frame& frame) {
       for (LandmarkMeasurement& measurement : frame.landmarks) measurement.range = 0.0;
     },
     {}},
    {"the same landmark everywhere",
     [](Frame& frame) {
       for (LandmarkMeasurement& measurement : frame.landmarks) measurement.id = 3;
     },
     {{"ekf", SlamReason::poor_match}}},
    {"the stamp before",
     [](Frame& frame) { frame.stamp -= ns_per_second / 10; },
     {{"ekf", SlamReason::repeated_frame}, {"hector", SlamReason::repeated_frame}}},
    {"a stamp far back",
     [](Frame& frame) { frame.stamp -= 100 * ns_per_second; },
     {{"ekf", SlamReason::repeated_frame}}},
    {"no stamp", [](Frame& frame) { frame.stamp = 0; }, {{"ekf", SlamReason::repeated_frame}}},
};

inline void fill_depth(Frame& frame, float meters) {
  for (int y = 0; y < frame.depth.height(); ++y) std::fill_n(frame.depth.row(y), frame.depth.width(), meters);
}

inline GrayImage gray(const Frame& frame, std::uint8_t value) {
  GrayImage image(frame.image.width(), frame.image.height());
  for (int y = 0; y < image.height(); ++y) std::fill_n(image.row(y), image.width(), value);
  return image;
}

inline constexpr std::size_t spoilt_images = 6;  ///< So many of them need no depth.
inline const Hostile spoilt_depths[] = {
    {"nothing at all",
     [](Frame& frame) {
       Frame bare;
       bare.index = frame.index;
       bare.stamp = frame.stamp;
       frame = bare;
     },
     {{"fusion", SlamReason::no_data},
      {"orb", SlamReason::no_data},
      {"rgbd", SlamReason::dark_or_blank},
      {"rtabmap", SlamReason::dark_or_blank},
      {"lsd", SlamReason::no_data}}},
    {"black", [](Frame& frame) { frame.image = gray(frame, 0); }, said_dark},
    {"white without color and depth",
     [](Frame& frame) {
       frame.image = gray(frame, 255);
       frame.color = {};
       frame.depth = {};
     },
     said_dark},
    {"everything masked",
     [](Frame& frame) { frame.mask = gray(frame, 0); },
     {{"fusion", SlamReason::few_inliers}, {"orb", SlamReason::few_inliers}, {"lsd", SlamReason::too_few_points}}},
    {"the stamp before",
     [](Frame& frame) { frame.stamp -= ns_per_second / 15; },
     {{"fusion", SlamReason::repeated_frame},
      {"orb", SlamReason::repeated_frame},
      {"rgbd", SlamReason::repeated_frame},
      {"rtabmap", SlamReason::repeated_frame},
      {"lsd", SlamReason::repeated_frame}}},
    {"no stamp",
     [](Frame& frame) { frame.stamp = 0; },
     {{"fusion", SlamReason::repeated_frame},
      {"orb", SlamReason::repeated_frame},
      {"rgbd", SlamReason::repeated_frame},
      {"rtabmap", SlamReason::repeated_frame},
      {"lsd", SlamReason::repeated_frame}}},
    {"no depth image", [](Frame& frame) { frame.depth = {}; }, {}},
    {"depth without a measurement", [](Frame& frame) { fill_depth(frame, 0.0F); }, {}},
    {"depth that is no number", [](Frame& frame) { fill_depth(frame, std::numeric_limits<float>::quiet_NaN()); }, {}},
    {"endless depth", [](Frame& frame) { fill_depth(frame, std::numeric_limits<float>::infinity()); }, {}},
    {"depth behind the camera", [](Frame& frame) { fill_depth(frame, -1.0F); }, {}},
    {"flat depth",
     [](Frame& frame) { fill_depth(frame, 1.0F); },
     {{"fusion", SlamReason::few_inliers},
      {"orb", SlamReason::few_inliers},
      {"rgbd", SlamReason::few_inliers},
      {"rtabmap", SlamReason::few_inliers}}},
};

inline std::span<const Hostile> spoilt_for(const TestRecording& recording) {
  if (!recording.info().cameras.empty() && !recording.info().has_depth)
    return std::span<const Hostile>(spoilt_depths).first(spoilt_images);
  return recording.info().has_depth ? std::span<const Hostile>(spoilt_depths) : std::span<const Hostile>(spoilt_scans);
}

/// Effect of a corrupt frame, as a factor on the method's limit. ORB relocalizes after a frame without features and
/// merges the submap made in between: with two cameras, that frame moves all others by 0.19 m.
inline double spoilt_factor(const std::string& method, const std::string& what) {
  if (what != "everything masked") return 1.0;
  if (method == "orb_stereo") return 5.0;
  return method == "orb_mono" ? 1.5 : 1.0;
}

}  // namespace rastro
