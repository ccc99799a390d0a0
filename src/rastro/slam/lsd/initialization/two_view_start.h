// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "rastro/base/task_pool.h"
#include "rastro/base/time.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"
#include "rastro/multiview/two_view.h"
#include "rastro/slam/lsd/inverse_depth_map.h"
#include "rastro/track/tracker.h"

namespace rastro {

struct TwoViewStartOptions {
  int features = 400;
  double min_parallax_deg = 1.0;
  int min_matches = 100;
  int frames = 60;  ///< Kept at most: the first frame is one of them.
  double pixel_sigma = 0.5;
  /// Of the points, seen from the other frames kept: the least share with an error of at most 3 sigma. Two views alone
  /// may agree on a wrong motion, with depths that no third view fits.
  double min_confirmed_share = 0.85;
  std::uint64_t seed = 1;
};

/// First depths from two views (the initialization of Mur-Artal et al. 2015, section IV), by features that are tracked
/// from frame to frame: a semi-dense map that starts near the truth needs no luck.
class TwoViewStart {
 public:
  /// An undistorted frame since the first view.
  struct KeptFrame {
    std::int64_t index = 0;
    TimeNs stamp = 0;
    GrayImage image;
    GrayImage mask;                                   ///< Zero: must not be used; empty: all may be.
    std::map<std::int64_t, TrackedFeature> features;  ///< By track.
  };
  struct Result {
    std::size_t first = 0;  ///< Into frames(); the second is the newest.
    SE3 second_from_first;  ///< Its unit gives `depth` the mean 1.
    InverseDepthMap depth;  ///< Of the first view, around each feature.
  };

  /// `camera`: a pinhole without distortion. `pool` may be null and must outlive this.
  TwoViewStart(const TwoViewStartOptions& options, const Camera& camera, TaskPool* pool);
  /// nullopt: not yet; detail() says why.
  std::optional<Result> take(std::int64_t index, TimeNs stamp, GrayImage image, GrayImage mask = {});
  const std::deque<KeptFrame>& frames() const { return frames_; }
  const std::string& detail() const { return detail_; }
  void reset();

 private:
  struct Matches {
    std::vector<std::int64_t> tracks;
    std::vector<TwoViewPair> pairs;
    std::vector<Eigen::Vector2f> pixels;  ///< In the first view.
  };
  Matches matches_with(std::size_t first) const;
  struct Attempt {
    TwoViewStatus status = TwoViewStatus::too_few_pairs;
    std::string detail;
    std::optional<Result> start;
  };
  Attempt try_first(std::size_t first) const;
  std::optional<Result> nearer_first();
  std::optional<double> confirmed_share(std::size_t first, const Matches& matches, const TwoViewFit& fit) const;
  InverseDepthMap depths_of(const Matches& matches, const TwoViewFit& fit) const;

  TwoViewStartOptions options_;
  Camera camera_;
  TaskPool* pool_;
  std::optional<Tracker> tracker_;
  std::deque<KeptFrame> frames_;
  std::size_t first_ = 0;
  std::string detail_;
};

/// Mean inverse depth where it is known; 0 where nothing is.
double mean_inverse_depth(const InverseDepthMap& depth);
/// Changes the unit: inverse depths are multiplied by `factor`.
void scale_inverse_depth(InverseDepthMap& depth, double factor);

}  // namespace rastro
