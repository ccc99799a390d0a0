// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/relocaliser.h"

#include <algorithm>

#include "rastro/base/random.h"

namespace rastro {

Relocaliser::Relocaliser(const RgbdSlamOptions& options, const Camera& camera, DepthStore& depths)
    : options_(options), depths_(depths), features_(options), matcher_(options, camera) {}

std::vector<std::int64_t> Relocaliser::candidates(std::int64_t count, std::uint64_t seed) {
  std::vector<std::int64_t> chosen;
  const auto take = [&](std::int64_t id) {
    if (id >= 0 && std::find(chosen.begin(), chosen.end(), id) == chosen.end()) chosen.push_back(id);
  };
  for (std::int64_t k = 1; k <= options_.relocalise_last; ++k) take(count - k);
  Random random(seed);
  for (int k = 0; k < options_.relocalise_random; ++k) {
    take(random.below(static_cast<std::uint32_t>(count)));
    take(next_by_turns_++ % count);
  }
  return chosen;
}

Relocaliser::Try Relocaliser::find(const Frame& frame,
                                   const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes,
                                   std::uint64_t seed) {
  Try result;
  if (keyframes.empty()) return result;
  const ImageFeatures seen = features_.extract(frame);
  result.features = static_cast<int>(seen.features.size());
  const auto grid = std::make_shared<const KeyframeSurface>(matcher_.surfaces().surface_of(frame.depth));
  for (const std::int64_t id : candidates(static_cast<std::int64_t>(keyframes.size()), seed)) {
    const ImageFeatures& keyframe = *keyframes[static_cast<std::size_t>(id)];
    if (keyframe.features.size() == 0) continue;
    ++result.compared;
    const auto tie =
        matcher_.match({&keyframe, [&] { return depths_.depth(id); }}, {&seen, [&] { return grid; }},
                       options_.relocalise_inliers, seed_for(seed, static_cast<std::uint64_t>(id)), std::nullopt);
    if (tie && (!result.found || tie->inliers > result.found->tie.inliers)) result.found = Found{id, *tie};
  }
  return result;
}

}  // namespace rastro
