// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/classic/classic_odometry.h"

#include <algorithm>

#include "rastro/base/checked_options.h"
#include "rastro/base/stopwatch.h"

namespace rastro {
namespace {

MatchedFeatures::Options matched_options(const ClassicOptions& options) {
  MatchedFeatures::Options matched;
  matched.descriptor = options.matcher;
  matched.extraction.max_keypoints = options.max_keypoints;
  matched.extraction.surf_threshold = options.surf_threshold;
  matched.extraction.sift_contrast = options.sift_contrast;
  matched.extraction.orb_fast_threshold = options.orb_fast_threshold;
  matched.matching.max_ratio = options.max_ratio;
  matched.matching.mutual = options.mutual;
  return matched;
}

}  // namespace

ClassicOdometry::ClassicOdometry(const ClassicOptions& options, const Camera& camera, TaskPool* pool)
    : options_(checked(options, "odometry options")),
      camera_(camera),
      check_(options_.check),
      matched_(matched_options(options_), camera, pool),
      chain_(options_, camera.fx) {}

OdometryUpdate ClassicOdometry::process(const Frame& frame) {
  Stopwatch watch;
  OdometryUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  const FrameCheckResult check = check_.check(frame.image, frame.stamp);
  update.reason = check.reason;
  update.detail = check.detail;
  if (!seen_.empty()) newest_id_ = std::max(newest_id_, seen_.back().id);
  seen_.clear();
  if (check.useful()) {
    seen_ = matched_.next(frame.image.view());
    chain_.add(seen_, update);
  } else {
    chain_.bridge(update);
  }
  update.milliseconds = watch.lap_ms();
  return update;
}

std::vector<OdometryFeature> ClassicOdometry::features() const {
  using State = OdometryFeature::State;
  std::vector<OdometryFeature> features;
  auto located = chain_.located().begin();
  for (const RayObservation& seen : seen_) {
    const auto pixel = camera_.project(seen.ray.homogeneous());
    if (!pixel) continue;
    State state = seen.id > newest_id_ ? State::fresh : State::matched;
    while (located != chain_.located().end() && located->first < seen.id) ++located;
    if (located != chain_.located().end() && located->first == seen.id)
      state = located->second ? State::inlier : State::outlier;
    features.push_back({pixel->cast<float>(), seen.id, state});
  }
  return features;
}

}  // namespace rastro
