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
  bool overwrite = false;  ///< Go ahead in a folder that already holds something; a former copy in it is removed first.
};

struct OccludedCopyResult {
  std::int64_t frames = 0;
  std::int64_t skipped = 0;         ///< Images that could not be read; each left a warning in the log.
  std::int64_t covered_frames = 0;  ///< Frames in which the occluder is seen.
  double covered_share = 0.0;       ///< Mean share of the pixels covered, over all frames.
};

/// Copies a recording with an Occluder drawn in, in EuRoC layout:
///   mav0/cam0/data.csv, mav0/cam0/data/STAMP.png   the pictures
///   mav0/cam0/sensor.yaml                          where the calibration is known
///   mav0/state_groundtruth_estimate0/data.csv      where ground truth is known
///   mav0/occluder/STAMP.png                        255 where the occluder covers the picture, else 0
///   mav0/occluder/occluder.yaml                    seed, source and passes
/// Files appear picture by picture, so an interrupted copy can be used up to there. The bytes follow from the source's
/// pixels and the seed alone. Errors: a folder that holds something, images of changing size, repeated stamps, a full
/// disk. `progress` is called after each batch with the number of frames written.
OccludedCopyResult write_occluded_copy(Source& source, const std::filesystem::path& folder,
                                       const OccludedCopyOptions& options, TaskPool& pool,
                                       const std::function<void(std::int64_t)>& progress = {});

}  // namespace rastro
