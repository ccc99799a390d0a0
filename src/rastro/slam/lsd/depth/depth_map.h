// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"
#include "rastro/slam/lsd/depth/epipolar_search.h"
#include "rastro/slam/lsd/inverse_depth_map.h"

namespace rastro {

struct DepthMapOptions {
  float min_gradient = 5.0F;         ///< Intensity levels per pixel, of the largest among the pixel and its neighbors.
  double start_sigma = 0.5;          ///< Of random inverse depths about 1.
  double max_relative_sigma = 0.5;   ///< Of an inverse depth: less certain ones are not begun.
  double growth = 1.01;              ///< Of the variance from frame to frame: what the model misses.
  double common_share = 0.7;         ///< Of an observation's variance, which no number of further ones reduces.
  double max_sigmas = 3.0;           ///< Between an observation and what is known, else it is a failure.
  int least_support = 3;             ///< Neighbors that agree with a depth, itself included, before it is shown.
  int most_failures = 5;             ///< In excess of successes, before a depth is dropped.
  double propagation_sigma = 0.005;  ///< Of an inverse depth of 1, added by a change of keyframe.
  double most_changed = 3.0;  ///< Sigmas of an intensity, beyond which another keyframe shows something else there.
  EpipolarSearchOptions search;
};

/// What became of the pixels with gradient in one observation.
struct DepthUpdate {
  int updated = 0, created = 0, contradicted = 0;
  std::array<int, epipolar_results> by_result{};

  DepthUpdate& operator+=(const DepthUpdate& other);
};

/// The inverse depths of a keyframe's pixels where it has gradient, from stereo with the frames tracked on it: J.
/// Engel, J. Sturm and D. Cremers, "Semi-Dense Visual Odometry for a Monocular Camera", 2013, section 2. Images are
/// undistorted. Results do not depend on the pool.
class DepthMap {
 public:
  /// Pixels where `mask` is zero, and those beside them, get no depth; empty: all may.
  DepthMap(GrayView image, const Camera& camera, const DepthMapOptions& options, GrayView mask = {});

  /// About 1 with a large variance, wherever there is gradient.
  void start_random(std::uint64_t seed);
  /// From depths known otherwise, where there is gradient.
  void start_from(const InverseDepthMap& depth);
  /// Intensity in the image = gain * intensity in the keyframe + offset. Pixels of the image where `mask` is zero say
  /// nothing; empty: all do.
  DepthUpdate observe(GrayView image, const SE3& image_from_keyframe, double gain, double offset,
                      TaskPool* pool = nullptr, GrayView mask = {});
  /// Finds inverse depths of a batch of pixels; called by many threads at once.
  using DepthSearch = std::function<void(const EpipolarQueries& queries, EpipolarMatches& matches)>;
  /// What a sensor of its own measures at this very frame: static stereo, or a depth camera. Where it contradicts what
  /// is known, it replaces that.
  DepthUpdate measure(const DepthSearch& sensor, TaskPool* pool = nullptr);
  /// Fills holes, drops outliers and smooths what agrees with its neighbors (sections 2.4 to 2.6). Sets
  /// inverse_depth().
  void regularize(TaskPool* pool = nullptr);
  /// The depths as another keyframe sees them (section 2.3): nearer ones hide others, and where its intensity is
  /// another one than gain * that of the keyframe + offset, the surface is hidden or has moved.
  DepthMap propagate(GrayView new_image, const SE3& new_from_keyframe, double gain, double offset,
                     GrayView new_mask = {}) const;
  /// Multiplies all inverse depths: another unit.
  void rescale(double factor);
  /// What pixels without a depth are expected to have: the mean, 1 unless said otherwise.
  void expect(double inverse_depth) { expected_ = inverse_depth; }

  double mean() const;  ///< Of all inverse depths, smoothed or not; 0 without any.
  /// Smoothed; as of the last regularize().
  const InverseDepthMap& inverse_depth() const { return smoothed_; }

 private:
  struct Filling {
    int x, y;
    float mean, variance;
  };
  DepthUpdate for_batches(const DepthSearch& search, bool is_sensor, TaskPool* pool);
  DepthUpdate update_rows(int begin, int end, const DepthSearch& search, bool is_sensor);
  void take(const EpipolarQueries& queries, const EpipolarMatches& matches, bool is_sensor, DepthUpdate& update);
  void add_query(int x, int y, bool is_sensor, EpipolarQueries& queries) const;
  void fuse(int x, int y, float found, float found_variance, bool is_sensor, DepthUpdate& update);
  void fail(int x, int y);
  void forget(int x, int y);
  void find_fillings(int y, std::vector<Filling>& fillings) const;
  Filling mean_around(int x, int y) const;
  void smooth_row(int y);
  void receive(int x, int y, float mean, float variance);

  DepthMapOptions options_;
  Camera camera_;
  GrayImage image_;
  Image<std::uint8_t> has_gradient_;
  InverseDepthMap depth_, smoothed_;
  Image<std::int8_t> failures_;  ///< Less successes.
  int observations_ = 0;
  double expected_ = 1.0;
};

}  // namespace rastro
