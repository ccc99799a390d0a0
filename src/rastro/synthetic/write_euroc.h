// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "rastro/base/task_pool.h"
#include "rastro/synthetic/frame_selection.h"
#include "rastro/synthetic/world.h"

namespace rastro {

struct EurocOptions {
  std::int64_t frames = 150;
  bool ground_truth = true;       ///< Also depth, surfaces and camera poses under mav0/truth.
  bool force = false;             ///< Write to a folder that is not empty, in place of such a recording there.
  bool stereo = false;            ///< Also the right camera, as mav0/cam1. Throws Error for a world without one.
  FrameSelection selection = {};  ///< Which frames; their stamps are those of the world.
};

struct EurocSummary {
  std::int64_t frames = 0;
  std::uintmax_t bytes = 0;
};

/// Writes a generated world as a EuRoC/ASL recording: mav0/cam0, mav0/state_groundtruth_estimate0 and, for scoring,
/// mav0/truth (the README written there has its format). Frames are rendered and written in parallel; the bytes are the
/// same for any pool. `progress` is called with the number of frames written so far. Throws Error for folders that
/// cannot be written or are not empty.
EurocSummary write_euroc(const World& world, const std::filesystem::path& folder, const EurocOptions& options,
                         TaskPool& pool, const std::function<void(std::int64_t)>& progress = {});

/// Step of the inverse depth (1/m) in the 16-bit depth images of mav0/truth: 5 m^-1 over 65535 steps, so that depths
/// from 0.2 m on reproject to within 0.02 px per meter of camera motion. 0 means no surface.
constexpr double inverse_depth_step = 5.0 / 65535.0;

}  // namespace rastro
