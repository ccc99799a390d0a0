// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/features/feature_source.h"

#include "rastro/feature/descriptor_extractor.h"
#include "rastro/odometry/matched_features.h"
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

class DescribedFeatures : public FeatureSource {
 public:
  DescribedFeatures(const FeaturesOptions& options, const Camera& camera, TaskPool* pool)
      : features_(matched_options(options), camera, pool) {}

  RayObservations next(const Frame& frame) override { return features_.next(frame.image.view()); }

 private:
  static MatchedFeatures::Options matched_options(const FeaturesOptions& options) {
    MatchedFeatures::Options matched;
    matched.descriptor = options.matcher;
    matched.extraction.max_keypoints = options.max_keypoints;
    matched.matching.max_ratio = options.max_ratio;
    return matched;
  }

  MatchedFeatures features_;
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
  return std::make_unique<DescribedFeatures>(options, camera, pool);
}

}  // namespace rastro
