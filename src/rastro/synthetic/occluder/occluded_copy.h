// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "rastro/base/task_pool.h"
#include "rastro/sensor/source.h"

namespace rastro {

struct OccludedCopyOptions {
  std::uint64_t seed = 1;
  bool overwrite = false;  ///< Write to a folder that is not empty; a former copy in it is removed first.
};

struct OccludedCopyResult {
  std::int64_t frames = 0;
  std::int64_t skipped = 0;         ///< Images that could not be read; each left a warning in the log.
  std::int64_t covered_frames = 0;  ///< Frames that show the occluder.
  double covered_share = 0.0;       ///< Mean share of covered pixels, over all frames.
};

/// Copies a recording with an Occluder drawn in, in EuRoC layout:
///   mav0/cam0/data.csv, mav0/cam0/data/STAMP.png   the images
///   mav0/cam0/sensor.yaml                          if the calibration is known
///   mav0/state_groundtruth_estimate0/data.csv      if ground truth is known
///   mav0/occluder/STAMP.png                        255 where the occluder covers the image, else 0
///   mav0/occluder/occluder.yaml                    seed, source and passes
/// Files are written image by image, so an interrupted copy can be used up to there. The bytes depend on the source's
/// pixels and the seed alone. Throws Error for a folder that is not empty, images of changing size, repeated stamps, a
/// full disk. `progress` is called after each batch with the number of frames written.
OccludedCopyResult write_occluded_copy(Source& source, const std::filesystem::path& folder,
                                       const OccludedCopyOptions& options, TaskPool& pool,
                                       const std::function<void(std::int64_t)>& progress = {});

}  // namespace rastro
