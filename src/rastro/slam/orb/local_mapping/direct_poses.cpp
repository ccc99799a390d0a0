// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/direct_poses.h"

#include <algorithm>

namespace rastro {
namespace {

constexpr int least_shared = 30;  // landmarks
constexpr std::size_t most_shared_count = 3, oldest_count = 2;

}  // namespace

std::shared_ptr<const DirectView> DirectPoses::add(std::int64_t keyframe, const DirectView* view) {
  if (alignment_ == nullptr || view == nullptr) return nullptr;
  auto made = alignment_->keyframe_of(*view);
  keyframes_.add(keyframe, made);
  return made;
}

std::vector<std::int64_t> DirectPoses::neighbors(std::int64_t keyframe) const {
  std::vector<std::int64_t> ids;
  for (const Neighbor& neighbor : graph_.covisible(keyframe, least_shared))
    if (keyframes_.find(neighbor.id) != nullptr) ids.push_back(neighbor.id);
  if (ids.size() <= most_shared_count) return ids;
  std::sort(ids.begin() + most_shared_count, ids.end());
  ids.resize(std::min(ids.size(), most_shared_count + oldest_count));
  return ids;
}

void DirectPoses::connect(std::int64_t keyframe) {
  if (keyframes_.find(keyframe) == nullptr) return;
  for (const std::int64_t other : neighbors(keyframe)) {
    align(other, keyframe);
    align(keyframe, other);
  }
}

void DirectPoses::align(std::int64_t keyframe, std::int64_t camera) {
  const SE3 guess = graph_.keyframe(camera).camera_from_world * graph_.keyframe(keyframe).camera_from_world.inverse();
  if (const auto pose = alignment_->align(*keyframes_.find(keyframe), *keyframes_.find(camera), guess))
    graph_.direct_poses().push_back({keyframe, camera, *pose});
}

}  // namespace rastro
