// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/export_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/export/landmark_export.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/scans/scan_layer.h"

namespace rastro::cli {
namespace {

/// Which formats use a flag, by what the input has; separated by spaces.
struct FlagUse {
  const char* flag;
  const char* of_images;
  const char* of_landmarks;
  const char* of_others;  ///< Scans, landmarks of a filter.
};

constexpr FlagUse uses[] = {
    {"--voxel", "ply pcd mesh", "", ""},
    {"--min-count", "ply pcd", "ply pcd colmap colmap-binary landmarks g2o svg png", ""},
    {"--resolution", "octomap pgm", "", ""},
    {"--height", "pgm", "", ""},
    {"--max-depth", "ply pcd mesh octomap pgm", "ply pcd colmap colmap-binary landmarks g2o svg png", ""},
    {"--stride", "ply pcd octomap pgm", "", ""},
    {"--submap", "html mcap ply pcd mesh octomap pgm g2o colmap tum kitti euroc",
     "html mcap ply pcd g2o colmap colmap-binary landmarks tum kitti euroc",
     "html mcap ply pcd pgm g2o tum kitti euroc"},
    {"--upright", "ply pcd mesh octomap pgm", "ply pcd", "ply pcd"},
    {"--images", "", "colmap colmap-binary mcap", "mcap"},
    {"--points", "html mcap", "html mcap", "html mcap"},
    {"--mesh", "html", "", ""},
    {"--octree", "html", "", ""},
    {"--objects", "html", "", ""},
};

struct InputKind {
  const char* FlagUse::*formats;
  const char* name;
};

/// formats is nullptr for poses alone, to which no flag applies.
InputKind kind_of(const ExportInput& input) {
  if (!input.map) return {nullptr, "poses"};
  if (input.map->layer<ImageLayer>()) return {&FlagUse::of_images, "a map with images"};
  if (has_observed_landmarks(*input.map)) return {&FlagUse::of_landmarks, "a map of landmarks"};
  return {&FlagUse::of_others, "a map of scans"};
}

bool is_near(const Map& map, const Landmark& landmark, double max_depth) {
  return std::any_of(landmark.observations.begin(), landmark.observations.end(), [&](const LandmarkObservation& each) {
    const Keyframe* keyframe = map.find(each.keyframe);
    return keyframe && (keyframe->world_from_camera.inverse() * landmark.position).z() <= max_depth;
  });
}

}  // namespace

void refuse_unused_flags(const std::vector<std::string>& given, const std::string& to, const ExportInput& input) {
  const InputKind kind = kind_of(input);
  for (const FlagUse& use : uses) {
    if (std::find(given.begin(), given.end(), use.flag) == given.end()) continue;
    const auto formats = split_words(kind.formats ? use.*kind.formats : "");
    if (std::find(formats.begin(), formats.end(), to) == formats.end())
      throw Error(fmt::format("does not apply to --to {} of {}", to, kind.name), use.flag, "omit it");
  }
}

void refuse_all_submaps(const std::string& to, const ExportInput& input) {
  const bool is_of_poses = to == "tum" || to == "kitti" || to == "euroc";
  const bool is_of_scans = to == "pgm" && input.map && input.map->layer<ScanLayer>();
  if (is_of_poses || is_of_scans)
    throw Error(fmt::format("--to {} holds one submap: each is in a frame of its own", to), "--submap all",
                "give a number; 'rastro info' lists them");
}

std::shared_ptr<const Map> with_landmarks_within(const Map& map, std::size_t min_count, double max_depth) {
  auto chosen = std::make_shared<Map>(map);
  const auto all = map.layer<LandmarkLayer>();
  RASTRO_CHECK(all && all->estimates.empty(), "a map of observed landmarks");
  auto kept = std::make_shared<LandmarkLayer>();
  for (const Landmark& landmark : all->landmarks)
    if (landmark.observations.size() >= min_count && is_near(map, landmark, max_depth))
      kept->landmarks.push_back(landmark);
  chosen->layers.put<LandmarkLayer>(std::move(kept));
  return chosen;
}

}  // namespace rastro::cli
