// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/place/vocabulary.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro::testing {

/// For tests only: points around a circle, with descriptors from a limited number of families, and what a camera
/// observes of them.
class RoundWorld {
 public:
  static constexpr double radius = 5.0;

  explicit RoundWorld(std::uint64_t seed) : random_(seed) {
    std::vector<Descriptor> kin(100);
    for (Descriptor& one : kin) {
      for (auto& word : one.words) word = random_.next();
    }
    for (int i = 0; i < 3000; ++i) {
      const double angle = random_.uniform(0.0, 2.0 * M_PI), far = random_.uniform(8.0, 12.0);
      const double height = random_.uniform(-2.0, 2.0);
      points.emplace_back(far * std::cos(angle), far * std::sin(angle), height);
      Descriptor descriptor = kin[random_.below(100)];
      flip(descriptor, 30);
      descriptors.push_back(descriptor);
    }
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 500.0;
    camera.cx = 319.5;
    camera.cy = 239.5;
  }

  /// Looking outward.
  static SE3 world_from_camera(double angle) {
    Eigen::Matrix3d rotation;
    rotation << std::sin(angle), 0.0, std::cos(angle), -std::cos(angle), 0.0, std::sin(angle), 0.0, -1.0, 0.0;
    return SE3(SO3::from_matrix(rotation), radius * rotation.col(2));
  }

  /// Half a pixel of noise and a few wrong bits; `seen` gets the point of each feature. `baseline` > 0: with depths,
  /// multiplied by `scale`.
  std::shared_ptr<const FeatureFrame> frame(std::int64_t id, const SE3& world_from_camera, double baseline,
                                            std::vector<std::uint32_t>& seen) {
    auto keyframe = std::make_shared<ImageFeatures>();
    keyframe->id = keyframe->frame = id;
    keyframe->stamp = 100000000 * (id + 1);
    seen.clear();
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d p = world_from_camera.inverse() * points[i];
      const auto pixel = camera.project(p);
      if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > 639 || pixel->y() > 479) continue;
      Keypoint keypoint;
      keypoint.x = static_cast<float>(pixel->x() + 0.5 * random_.normal());
      keypoint.y = static_cast<float>(pixel->y() + 0.5 * random_.normal());
      Descriptor descriptor = descriptors[i];
      flip(descriptor, 8);
      const double level = std::round(std::log(15.0 / p.norm()) / std::log(1.2));
      keyframe->features.keypoints.push_back(keypoint);
      keyframe->features.levels.push_back(static_cast<std::uint8_t>(std::clamp(level, 0.0, 7.0)));
      keyframe->features.descriptors.push_back(descriptor);
      if (baseline > 0.0) keyframe->depths.push_back(static_cast<float>(p.z()));
      seen.push_back(i);
    }
    return std::make_shared<FeatureFrame>(std::move(keyframe), camera, baseline);
  }

  /// Trained on these points, one image per sector.
  std::shared_ptr<const Vocabulary> vocabulary() const {
    std::vector<std::vector<Descriptor>> sectors(40);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double fraction = std::atan2(points[i].y(), points[i].x()) / (2.0 * M_PI) + 0.5;
      sectors[std::min<std::size_t>(39, static_cast<std::size_t>(40.0 * fraction))].push_back(descriptors[i]);
    }
    VocabularyOptions options;
    options.depth = 3;
    return std::make_shared<Vocabulary>(Vocabulary::train(sectors, options));
  }

  std::vector<Eigen::Vector3d> points;
  std::vector<Descriptor> descriptors;
  Camera camera;

 private:
  void flip(Descriptor& descriptor, int bits) {
    for (int k = 0; k < bits; ++k) {
      const std::uint32_t word = random_.below(4);
      descriptor.words[word] ^= std::uint64_t{1} << random_.below(64);
    }
  }

  Random random_;
};

/// Makes a map with odometry drift: heading and scale drift, and points out of view for a while become new landmarks.
class DriftingMapper {
 public:
  DriftingMapper(RoundWorld& world, MapGraph& graph, double yaw_step, double growth)
      : world_(world), graph_(graph), yaw_step_(yaw_step), growth_(growth) {}

  /// Starts a submap in a frame of its own, with a unit of 1 / `scale` meters.
  void begin(int submap, const SE3& world_from_first, double scale) {
    submap_ = submap;
    pose_ = world_from_first;
    scale_ = scale;
    parent_ = -1;
    landmark_of_.assign(world_.points.size(), -1);
    last_seen_.assign(world_.points.size(), -100);
  }

  std::int64_t add(double angle) {
    const SE3 ground_truth = RoundWorld::world_from_camera(angle);
    if (parent_ >= 0) {
      const SE3 step = true_pose_.inverse() * ground_truth;
      pose_ = pose_ * SE3(step.rotation() * SO3::exp({0.0, yaw_step_, 0.0}), scale_ * step.translation());
      scale_ *= growth_;
    }
    true_pose_ = ground_truth;
    const std::int64_t id = static_cast<std::int64_t>(scales.size());
    std::vector<std::uint32_t> seen;
    graph_.add_keyframe(world_.frame(id, ground_truth, graph_.baseline(), seen), pose_.inverse(), submap_, parent_);
    for (std::uint32_t feature = 0; feature < seen.size(); ++feature) {
      const std::uint32_t point = seen[feature];
      if (last_seen_[point] + 3 < id) {
        const Eigen::Vector3d in_camera = scale_ * (ground_truth.inverse() * world_.points[point]);
        landmark_of_[point] = graph_.add_landmark(pose_ * in_camera, id).id;
      }
      last_seen_[point] = id;
      graph_.add_observation(id, feature, landmark_of_[point]);
      graph_.describe(landmark_of_[point]);
    }
    scales.push_back(scale_);
    centers.push_back(ground_truth.translation());
    parent_ = id;
    return id;
  }

  std::vector<double> scales;            ///< Map units per meter at each keyframe when it was made.
  std::vector<Eigen::Vector3d> centers;  ///< Ground truth.

 private:
  RoundWorld& world_;
  MapGraph& graph_;
  double yaw_step_, growth_;
  int submap_ = 0;
  std::int64_t parent_ = -1;
  SE3 pose_, true_pose_;
  double scale_ = 1.0;
  std::vector<std::int64_t> landmark_of_, last_seen_;
};

}  // namespace rastro::testing
