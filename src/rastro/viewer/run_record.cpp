// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/run_record.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "rastro/viewer/scene_parts.h"

namespace rastro {
namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

/// Rows of the frames by their stamps.
class FrameRows {
 public:
  explicit FrameRows(const std::vector<double>& stamps_s) {
    for (std::size_t row = 0; row < stamps_s.size(); ++row) rows_.emplace_back(from_seconds(stamps_s[row]), row);
    std::sort(rows_.begin(), rows_.end());
  }
  std::size_t count() const { return rows_.size(); }

  /// Calls visit(row, item) for each item whose stamp is that of a frame.
  template <typename Item, typename Visit>
  void join(const std::vector<Item>& items, const Visit& visit) const {
    for (const Item& item : items) {
      // Seconds as a double are only as fine as a quarter of a microsecond.
      constexpr TimeNs tolerance = 1'000;
      constexpr TimeNs largest = std::numeric_limits<TimeNs>::max() - tolerance;  // of files that may say anything
      const TimeNs stamp = std::clamp(item.stamp, -largest, largest);
      auto found = std::lower_bound(rows_.begin(), rows_.end(), std::pair{stamp - tolerance, std::size_t{0}});
      if (found != rows_.end() && found->first <= stamp + tolerance) visit(found->second, item);
    }
  }

 private:
  std::vector<std::pair<TimeNs, std::size_t>> rows_;
};

void set(std::vector<float>& numbers, std::size_t row, const Eigen::Vector3d& vector) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    numbers[3 * row + axis] = static_cast<float>(vector[static_cast<Eigen::Index>(axis)]);
}

Eigen::Vector3d vector_at(const std::vector<float>& numbers, std::size_t row) {
  return Eigen::Vector3f(numbers[3 * row], numbers[3 * row + 1], numbers[3 * row + 2]).cast<double>();
}

std::uint8_t index_of_state(const std::string& state) {
  const auto& names = scene_state_names();
  const auto found = std::find(names.begin(), names.end(), state);
  return static_cast<std::uint8_t>((found == names.end() ? names.end() - 1 : found) - names.begin());
}

void add_states(const RunRecord& record, const FrameRows& rows, SceneFrames& frames) {
  if (record.frames.empty()) return;
  frames.states.assign(rows.count(), index_of_state("unknown"));
  frames.milliseconds.assign(rows.count(), nan_value);
  rows.join(record.frames, [&](std::size_t row, const RunRecord::Frame& frame) {
    frames.states[row] = index_of_state(frame.state);
    frames.milliseconds[row] = static_cast<float>(frame.milliseconds);
  });
}

void add_online(const RunRecord& record, const FrameRows& rows, SceneFrames& frames) {
  if (record.online.empty()) return;
  frames.online.assign(3 * rows.count(), nan_value);
  rows.join(record.online, [&](std::size_t row, const StampedPose& pose) {
    set(frames.online, row, pose.world_from_body.translation());
  });
}

void add_truth(const RunRecord& record, const FrameRows& rows, SceneFrames& frames) {
  if (record.truth.empty()) return;
  frames.truth.assign(3 * rows.count(), nan_value);
  frames.errors.assign(rows.count(), nan_value);
  rows.join(record.truth, [&](std::size_t row, const RunRecord::Truth& truth) {
    set(frames.truth, row, truth.position);
    frames.errors[row] = static_cast<float>((truth.position - vector_at(frames.positions, row)).norm());
  });
}

/// Sigmas of all frames, and ellipsoids of some.
void add_uncertainties(const RunRecord& record, const FrameRows& rows, ViewScene& scene) {
  constexpr std::size_t most_ellipsoids = 300;
  if (record.uncertainties.empty()) return;
  scene.frames.sigmas.assign(rows.count(), nan_value);
  std::vector<std::pair<std::size_t, const Eigen::Matrix3d*>> known;
  rows.join(record.uncertainties, [&](std::size_t row, const RunRecord::Uncertainty& each) {
    if (!each.covariance.allFinite()) return;
    scene.frames.sigmas[row] = static_cast<float>(std::sqrt(std::max(0.0, each.covariance.trace())));
    known.emplace_back(row, &each.covariance);
  });
  SceneEllipsoids ellipsoids;
  ellipsoids.name = "pose_covariances";
  for (const std::size_t k : detail::evenly(known.size(), most_ellipsoids)) {
    detail::append(ellipsoids.centers, vector_at(scene.frames.positions, known[k].first));
    detail::append_axes(ellipsoids.axes, *known[k].second);
  }
  if (!ellipsoids.centers.empty()) scene.layers.emplace_back(std::move(ellipsoids));
}

void add_events(const RunRecord& record, const FrameRows& rows, ViewScene& scene) {
  std::map<std::int64_t, SceneEvent> of_frames;
  for (const RunRecord::Frame& frame : record.frames)
    of_frames[frame.frame] = {SceneEvent::no_pose, to_seconds(frame.stamp), {}, {}};
  rows.join(record.frames, [&](std::size_t row, const RunRecord::Frame& frame) {
    of_frames[frame.frame].frame = static_cast<std::int64_t>(row);
  });
  for (const RunRecord::Event& event : record.events) {
    const auto frame = of_frames.find(event.frame);
    if (frame == of_frames.end()) continue;  // of a frame that could not be read
    scene.events.push_back({frame->second.frame, frame->second.stamp_s, event.kind, event.detail});
  }
}

}  // namespace

void add_run(const RunRecord& record, ViewScene& scene) {
  if (record.trajectory.size() > scene.frames.stamps_s.size()) detail::set_frames(record.trajectory, scene.frames);
  const FrameRows rows(scene.frames.stamps_s);
  add_states(record, rows, scene.frames);
  add_online(record, rows, scene.frames);
  add_truth(record, rows, scene.frames);
  add_uncertainties(record, rows, scene);
  add_events(record, rows, scene);
}

}  // namespace rastro
