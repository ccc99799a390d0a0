// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/matched_features.h"

#include <algorithm>
#include <utility>

namespace rastro {

MatchedFeatures::MatchedFeatures(const Options& options, const Camera& camera, TaskPool* pool)
    : camera_(camera),
      pool_(pool),
      extractor_(DescriptorExtractor::create(descriptor_kind(options.descriptor, "matcher"), options.extraction)),
      matching_(options.matching) {}

RayObservations MatchedFeatures::next(GrayView image) {
  Features current = extractor_->extract(image);
  std::vector<std::int64_t> ids(current.size(), -1);
  if (last_.size() > 0 && current.size() > 0) {
    for (const DescriptorMatch& match : match_descriptors(last_, current, matching_, pool_))
      ids[match.second] = last_ids_[match.first];
  }
  RayObservations observations;
  for (std::size_t i = 0; i < current.size(); ++i) {
    if (ids[i] < 0) ids[i] = next_id_++;
    const Keypoint& keypoint = current.keypoints[i];
    const auto ray = camera_.unproject({static_cast<double>(keypoint.x), static_cast<double>(keypoint.y)});
    if (ray) observations.push_back({ids[i], *ray});
  }
  std::sort(observations.begin(), observations.end(),
            [](const RayObservation& a, const RayObservation& b) { return a.id < b.id; });
  last_ = std::move(current);
  last_ids_ = std::move(ids);
  return observations;
}

}  // namespace rastro
