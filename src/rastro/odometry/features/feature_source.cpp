// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/features/feature_source.h"

#include <algorithm>

#include "rastro/feature/descriptor_extractor.h"
#include "rastro/feature/descriptor_matching.h"
#include "rastro/track/tracker.h"

namespace rastro {
namespace {

/// A pose tolerates a wrong feature better than a lost one, so this tracks more leniently than where tracks are the
/// result. To a moving camera a feature hardly ever reappears after some frames.
TrackOptions tracker_options(const FeaturesOptions& options) {
  TrackOptions track;
  track.features = options.features;
  track.min_distance_px = options.min_distance_px;
  track.seed = options.seed;
  track.max_residual_ratio = 0.4;
  track.max_reference_residual = 0.0;
  track.max_epipolar_error_px = 2.0;
  track.max_backward_px = 1.0;
  track.flow_levels = 5;
  track.flow_window_px = 17;
  track.flow_coarse_epsilon_px = 0.1;
  track.window = 6;
  track.candidates_factor = 1.0;
  track.candidates_distance_px = 0.0;
  track.verify_corners = false;
  return track;
}

class TrackedFeatures : public FeatureSource {
 public:
  TrackedFeatures(const FeaturesOptions& options, const Camera& camera, TaskPool* pool)
      : tracker_(tracker_options(options), camera, pool) {}

  RayObservations next(const Frame& frame) override {
    RayObservations observations;
    for (const TrackedFeature& feature : tracker_.process(frame.image.view(), frame.stamp).features) {
      if (feature.ray.allFinite()) observations.push_back({feature.id, feature.ray.cast<double>()});
    }
    return observations;
  }

 private:
  Tracker tracker_;
};

class MatchedFeatures : public FeatureSource {
 public:
  MatchedFeatures(const FeaturesOptions& options, const Camera& camera, TaskPool* pool) : camera_(camera), pool_(pool) {
    DescriptorExtractorOptions extraction;
    extraction.max_keypoints = options.max_keypoints;
    extractor_ = DescriptorExtractor::create(descriptor_kind(options.matcher, "matcher"), extraction);
    matching_.max_ratio = options.max_ratio;
  }

  RayObservations next(const Frame& frame) override {
    Features current = extractor_->extract(frame.image.view());
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

 private:
  Camera camera_;
  TaskPool* pool_;
  std::unique_ptr<DescriptorExtractor> extractor_;
  DescriptorMatchOptions matching_;
  Features last_;
  std::vector<std::int64_t> last_ids_;
  std::int64_t next_id_ = 0;
};

}  // namespace

std::vector<std::string> matcher_names() {
  std::vector<std::string> names = {"tracks", "sift", "orb"};
  if (has_surf()) names.emplace_back("surf");
  return names;
}

std::unique_ptr<FeatureSource> make_feature_source(const FeaturesOptions& options, const Camera& camera,
                                                   TaskPool* pool) {
  if (options.matcher == "tracks") return std::make_unique<TrackedFeatures>(options, camera, pool);
  return std::make_unique<MatchedFeatures>(options, camera, pool);
}

}  // namespace rastro
