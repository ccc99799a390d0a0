// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/multiview/two_view.h"
#include "rastro/slam/orb/map/feature_frame.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// Two frames that initialize a map.
struct InitialPair {
  std::size_t first = 0, second = 0;  ///< Indices into Initializer::frames().
  SE3 second_from_first;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  std::vector<std::optional<Eigen::Vector3d>> points;  ///< One per pair, in the first camera's frame.
};

/// Two-view initialization: waits for two frames of one camera that determine motion and points, METHODS 6. Keeps the
/// features of the frames since, so that frames before and between the two can be tracked once there is a map.
class Initializer {
 public:
  Initializer(const OrbSlamOptions& options, const Camera& camera) : options_(options), camera_(camera) {}

  /// nullopt: not yet; detail() gives the reason.
  std::optional<InitialPair> add(std::shared_ptr<const FeatureFrame> frame);
  /// Keeps frames once there is a map, in case it has to be initialized again.
  void keep(std::shared_ptr<const FeatureFrame> frame);
  const std::deque<std::shared_ptr<const FeatureFrame>>& frames() const { return frames_; }
  const std::string& detail() const { return detail_; }
  void clear();

 private:
  struct Attempt {
    TwoViewStatus status = TwoViewStatus::too_few_pairs;
    std::string detail;
    std::optional<InitialPair> start;
  };

  Attempt try_pair(std::size_t first, std::size_t second) const;
  std::optional<InitialPair> nearer_pair(std::size_t second);

  OrbSlamOptions options_;
  Camera camera_;
  std::deque<std::shared_ptr<const FeatureFrame>> frames_;
  std::size_t first_ = 0;  ///< Frame that the newest one is matched with.
  std::string detail_;
};

}  // namespace rastro
