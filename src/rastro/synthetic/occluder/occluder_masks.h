// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <list>
#include <memory>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/image/image.h"

namespace rastro {

/// The occluder masks of a folder written by write_occluded_copy(), loaded on demand; the last ones stay in memory.
class OccluderMasks {
 public:
  /// True if the folder has masks.
  static bool present(const std::filesystem::path& data_folder);
  explicit OccluderMasks(std::filesystem::path data_folder) : folder_(std::move(data_folder)) {}

  /// True if any pixel within `radius_px` of the position is covered. Throws Error if the frame of this stamp has no
  /// mask.
  bool covered(TimeNs stamp, const Eigen::Vector2d& pixel, double radius_px) const;
  /// 255 where covered, else 0. The reference is valid until the next call.
  const GrayImage& mask(TimeNs stamp) const;

 private:
  std::filesystem::path folder_;
  mutable std::list<std::pair<TimeNs, GrayImage>> recent_;  ///< The last used one is in front.
};

}  // namespace rastro
