// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/refinement/frame_correction.h"

#include <algorithm>
#include <cstddef>
#include <map>

namespace rastro {
namespace {

/// Frames in a row that were aligned with the same keyframe: [first, end).
struct Run {
  std::size_t first = 0, end = 0;
};

std::vector<Run> runs_of(const std::vector<PlacedFrame>& frames) {
  std::vector<Run> runs;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (k == 0 || frames[k].keyframe != frames[k - 1].keyframe) runs.push_back({k, k});
    runs.back().end = k + 1;
  }
  return runs;
}

/// In the unit of `from`.
SE3 corrected_step(const SemiDenseGraph& graph, std::int64_t from, std::int64_t to) {
  const Sim3 from_from_to = graph.pose(from).inverse() * graph.pose(to);
  return {from_from_to.rotation(), from_from_to.translation()};
}

/// `changed`: of the run, the frame that became keyframe `next`.
void correct(const SemiDenseGraph& graph, const Run& run, std::size_t changed, std::int64_t next,
             std::vector<PlacedFrame>& frames) {
  const std::int64_t keyframe = frames[changed].keyframe;
  const std::int64_t begin = std::max(frames[run.first].index, graph.keyframe(keyframe).frame);
  const auto length = static_cast<double>(std::max<std::int64_t>(1, frames[changed].index - begin));
  const Vector6d correction =
      (corrected_step(graph, keyframe, next) * frames[changed].keyframe_from_camera.inverse()).log();
  for (std::size_t k = run.first; k < run.end; ++k) {
    const double share = std::clamp(static_cast<double>(frames[k].index - begin) / length, 0.0, 1.0);
    frames[k].keyframe_from_camera = SE3::exp(share * correction) * frames[k].keyframe_from_camera;
  }
}

}  // namespace

std::vector<PlacedFrame> frames_between_corrected_keyframes(const SemiDenseGraph& graph) {
  std::map<std::int64_t, std::int64_t> keyframe_of;  // by the frame that became one
  for (std::int64_t id = 0; id < graph.size(); ++id) keyframe_of[graph.keyframe(id).frame] = id;
  std::vector<PlacedFrame> frames = graph.frames();
  for (const Run& run : runs_of(frames)) {
    for (std::size_t k = run.first; k < run.end; ++k) {
      const auto became = keyframe_of.find(frames[k].index);
      if (became == keyframe_of.end() || became->second == frames[k].keyframe) continue;
      if (graph.submap(became->second) != graph.submap(frames[k].keyframe)) continue;
      correct(graph, run, k, became->second, frames);
      break;
    }
  }
  return frames;
}

}  // namespace rastro
