// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/reappearance.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "rastro/feature/hamming.h"
#include "rastro/multiview/homography.h"
#include "rastro/track/local_motion.h"

namespace rastro {
namespace {

class Search {
 public:
  Search(std::span<const Association> followed, const TrackStore& store, std::int64_t current, MotionHistory& history,
         const UndistortedCamera& camera, const Pyramid& image, const HasRoom& has_room,
         const DescribeRotated& describe, const TrackOptions& options)
      : followed_(followed),
        store_(store),
        current_(current),
        history_(history),
        camera_(camera),
        image_(image),
        has_room_(has_room),
        describe_(describe),
        options_(options) {
    klt_.iterations = options.flow_iterations;
    klt_.epsilon_px = options.flow_epsilon_px;
    klt_.min_eigenvalue = options.min_alignment_texture;
  }

  std::optional<Reappeared> find(std::size_t index) {
    const int first = std::max(0, store_[index].layer), second = 1 - first;
    const auto expected = expected_position(index, first);
    if (expected) {
      if (const auto found = find_at(index, first, *expected)) return found;
    }
    const auto other = expected_position(index, second);
    // Where both layers have the same motion, nothing has reappeared.
    constexpr double alike_px = 1.0;
    if (!other || (expected && (*other - *expected).norm() < alike_px)) return std::nullopt;
    return find_at(index, second, *other);
  }

 private:
  std::optional<Eigen::Vector2d> expected_position(std::size_t index, int layer) {
    const Track& track = store_[index];
    const MotionHistory::Motion* motion = history_.since(track.last_seen, layer, followed_, store_);
    if (!motion) return std::nullopt;
    return moved_pixel(motion->current_from_frame, track.undistorted_in(track.last_seen), camera_);
  }

  std::optional<Reappeared> find_at(std::size_t index, int layer, const Eigen::Vector2d& expected) {
    if (!has_room_(expected.cast<float>())) return std::nullopt;
    const Track& track = store_[index];
    const Eigen::Vector2f& last = track.undistorted_in(track.last_seen);
    const MotionHistory::Motion& motion = *history_.since(track.last_seen, layer, followed_, store_);
    const auto warp = derivative_at(motion.current_from_frame, last);
    if (!warp || !is_alike(track, expected.cast<float>(), *warp, prefilter_slack)) return std::nullopt;
    const KltResult found = align(track, layer, expected.cast<float>());
    if (!found.followed || !has_room_(found.pixel) || !is_alike(track, found.pixel, *warp, 0)) return std::nullopt;
    if (motion.inlier_share < options_.min_inlier_share &&
        !agrees_with_neighbors(motion.shared, last.cast<double>(), camera_.from_pixel(found.pixel).cast<double>(),
                               options_.max_reprojection_px))
      return std::nullopt;
    return Reappeared{index, found.pixel, found.residual_ratio};
  }

  // Before alignment a position may be wrong by a pixel or two.
  static constexpr int prefilter_slack = 8;

  bool is_alike(const Track& track, const Eigen::Vector2f& pixel, const Eigen::Matrix2f& warp, int slack) {
    const double angle = std::atan2(static_cast<double>(warp(1, 0) - warp(0, 1)), static_cast<double>(warp.trace()));
    const double scale = std::sqrt(static_cast<double>(warp.determinant()));
    const Descriptor seen = describe_(pixel, angle, scale);
    distances_.resize(track.descriptors().size());
    hamming_distances(seen, track.descriptors(), distances_);
    int votes = 0;
    for (std::size_t slot = 0; slot < track.frames().size(); ++slot) {
      if (track.frames()[slot] < 0 || track.frames()[slot] < current_ - store_.window()) continue;
      votes += distances_[slot] <= options_.max_hamming + slack ? 1 : 0;
    }
    return votes >= options_.min_votes;
  }

  KltResult align_patch(const KltReference& patch, std::int64_t frame, const Track& track, int layer,
                        const Eigen::Vector2f& pixel) {
    const auto warp = history_.rotated_since(frame, layer, track, followed_, store_);
    const double reach = std::min(options_.max_alignment_px, options_.max_reprojection_px);
    return warp ? patch.align(image_, pixel, reach, klt_, *warp) : KltResult{};
  }

  KltResult align(const Track& track, int layer, const Eigen::Vector2f& pixel) {
    const bool just_lost = track.last_seen >= current_ - options_.reference_interval;
    klt_.max_residual_ratio = just_lost ? options_.max_residual_ratio : options_.max_alignment_residual;
    const KltResult older = align_patch(track.reference_patch(), track.patch_frame(), track, layer, pixel);
    if (older.followed && older.residual_ratio <= static_cast<float>(options_.max_residual_ratio)) return older;
    const KltResult newer = align_patch(track.newest_patch(), track.newest_patch_frame(), track, layer, pixel);
    return older.followed && (!newer.followed || older.residual_ratio <= newer.residual_ratio) ? older : newer;
  }

  std::span<const Association> followed_;
  const TrackStore& store_;
  std::int64_t current_;
  MotionHistory& history_;
  const UndistortedCamera& camera_;
  const Pyramid& image_;
  const HasRoom& has_room_;
  const DescribeRotated& describe_;
  const TrackOptions& options_;
  KltOptions klt_;
  std::vector<std::uint16_t> distances_;  ///< Scratch.
};

}  // namespace

std::vector<Reappeared> find_reappeared(std::span<const Association> followed, const TrackStore& store,
                                        std::int64_t current, MotionHistory& history, const UndistortedCamera& camera,
                                        const Pyramid& image, const HasRoom& has_room, const DescribeRotated& describe,
                                        const TrackOptions& options) {
  Search search(followed, store, current, history, camera, image, has_room, describe, options);
  std::vector<Reappeared> found;
  for (const std::size_t index : store.lost()) {
    if (const auto reappeared = search.find(index)) found.push_back(*reappeared);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Reappeared& a, const Reappeared& b) { return a.residual_ratio < b.residual_ratio; });
  return found;
}

}  // namespace rastro
