// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/feature/descriptor_extractor.h"
#include "rastro/feature/descriptor_matching.h"
#include "rastro/odometry/ray_observations.h"

namespace rastro {

/// Features with descriptors, matched from frame to frame: a matched one has the id of its match. The pool must outlive
/// it; results do not depend on it.
class MatchedFeatures {
 public:
  struct Options {
    std::string descriptor = "sift";  ///< sift, orb or surf.
    DescriptorExtractorOptions extraction;
    DescriptorMatchOptions matching;
  };

  /// Throws Error for an unknown descriptor, and for SURF in a build without it.
  MatchedFeatures(const Options& options, const Camera& camera, TaskPool* pool);

  /// Images come in the order of the recording. Features outside the camera model are left out.
  RayObservations next(GrayView image);

 private:
  Camera camera_;
  TaskPool* pool_;
  std::unique_ptr<DescriptorExtractor> extractor_;
  DescriptorMatchOptions matching_;
  Features last_;
  std::vector<std::int64_t> last_ids_;
  std::int64_t next_id_ = 0;
};

}  // namespace rastro
