// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/validation.h"

#include <algorithm>

#include "rastro/base/random.h"
#include "rastro/multiview/fundamental.h"
#include "rastro/multiview/homography.h"
#include "rastro/track/local_motion.h"

namespace rastro {
namespace {

/// A homography with a large inlier share is accepted. One with a small share may be that of another plane or of an
/// occluder, and so confirms only what the nearest features confirm too.
class HomographyModel : public Validation::Model {
 public:
  HomographyModel(const Eigen::Matrix3d& homography, double max_error, bool believed, PointPairs pairs)
      : homography_(homography), max_error_(max_error), believed_(believed), pairs_(std::move(pairs)) {}
  bool agrees(const Eigen::Vector2d& in_window_frame, const Eigen::Vector2d& in_current) const override {
    const auto expected = transfer(homography_, in_window_frame);
    if (!expected || (*expected - in_current).norm() > max_error_) return false;
    return believed_ || agrees_with_neighbors(pairs_, in_window_frame, in_current, max_error_);
  }

 private:
  Eigen::Matrix3d homography_;
  double max_error_;
  bool believed_;
  PointPairs pairs_;
};

class EpipolarModel : public Validation::Model {
 public:
  EpipolarModel(const Eigen::Matrix3d& fundamental, double max_error)
      : fundamental_(fundamental), max_error_(max_error) {}
  bool agrees(const Eigen::Vector2d& in_window_frame, const Eigen::Vector2d& in_current) const override {
    return sampson_distance_squared(fundamental_, in_window_frame, in_current) <= max_error_ * max_error_;
  }

 private:
  Eigen::Matrix3d fundamental_;
  double max_error_;
};

class LocalModel : public Validation::Model {
 public:
  LocalModel(PointPairs pairs, double max_error) : pairs_(std::move(pairs)), max_error_(max_error) {}
  bool agrees(const Eigen::Vector2d& in_window_frame, const Eigen::Vector2d& in_current) const override {
    return agrees_with_neighbors(pairs_, in_window_frame, in_current, max_error_);
  }

 private:
  PointPairs pairs_;
  double max_error_;
};

}  // namespace

Validation::Validation(const TrackStore& store, std::int64_t current, std::span<const Association> associations,
                       const TrackOptions& options)
    : store_(store), current_(current), associations_(associations), options_(options) {}

Validation::~Validation() = default;

bool Validation::confirms(std::size_t track_index, const Eigen::Vector2f& pixel) {
  const Track& track = store_[track_index];
  const std::int64_t oldest = std::max<std::int64_t>(0, current_ - store_.window());
  for (std::int64_t frame = track.last_seen; frame >= oldest; --frame) {
    if (!track.seen_in(frame)) continue;
    const Model* model = model_of(frame);
    if (model && model->agrees(track.pixel_in(frame).cast<double>(), pixel.cast<double>())) return true;
  }
  return false;
}

const Validation::Model* Validation::model_of(std::int64_t frame) {
  const auto [found, added] = models_.try_emplace(frame);
  if (added) found->second = estimate(frame);
  return found->second.get();
}

std::unique_ptr<Validation::Model> Validation::estimate(std::int64_t frame) const {
  PointPairs pairs;
  for (const Association& association : associations_) {
    const Track& track = store_[association.track];
    if (track.seen_in(frame)) pairs.add(track.pixel_in(frame), association.pixel);
  }
  if (static_cast<int>(pairs.size()) < options_.min_inliers) return nullptr;
  if (options_.validation == "local")
    return std::make_unique<LocalModel>(std::move(pairs), options_.max_reprojection_px);

  const auto frames_seed = seed_for(options_.seed, static_cast<std::uint64_t>(current_));
  const RansacOptions ransac{options_.max_reprojection_px, 0.99, options_.ransac_iterations,
                             seed_for(frames_seed, static_cast<std::uint64_t>(frame))};
  const bool epipolar = options_.validation == "epipolar";
  const auto fit = epipolar ? estimate_fundamental(pairs, ransac) : estimate_homography(pairs, ransac);
  if (!fit || fit->inliers < options_.min_inliers) return nullptr;
  if (epipolar) return std::make_unique<EpipolarModel>(fit->model, options_.max_reprojection_px);
  const bool believed = fit->inliers >= options_.min_inlier_share * static_cast<double>(pairs.size());
  return std::make_unique<HomographyModel>(fit->model, options_.max_reprojection_px, believed, std::move(pairs));
}

}  // namespace rastro
