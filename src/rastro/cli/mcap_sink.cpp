// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/mcap_sink.h"

#include <utility>

#include "rastro/base/version.h"
#include "rastro/cli/mcap_input.h"
#include "rastro/cli/scene_input.h"
#include "rastro/map/images/pack_images.h"

namespace rastro::cli {
namespace {

McapRun about_run(const std::string& out, const std::string& method, const SourceInfo& source) {
  McapRun about;
  about.of_camera = source.has_image;
  if (!source.has_image) about.up = Eigen::Vector3d::UnitZ();
  if (!source.cameras.empty() && source.cameras.front().camera) about.camera = source.cameras.front().camera;
  about.facts = {{"name", scene_name(out)}, {"method", method}, {"program", "rastro " + version().number}};
  return about;
}

bool has_keyframe(const SlamUpdate& update) {
  for (const SlamEvent& event : update.events)
    if (event.kind == "keyframe") return true;
  return false;
}

std::string jpeg_of_frame(const Frame& frame) {
  Frame seen;
  seen.image = frame.image;
  seen.color = frame.color;
  const PackedImages packed = pack_images(seen);
  return {packed.color.begin(), packed.color.end()};
}

}  // namespace

McapSink::McapSink(const std::string& file, const std::string& out, const std::string& method, const SourceInfo& source)
    : out_(out),
      file_(file),
      recorder_(about_run(out, method, source), [this](std::string_view piece) { file_.append(piece); }) {}

void McapSink::add_state(TimeNs stamp, const std::string& state, const std::string& why) {
  if (std::exchange(last_state_, state + " " + why.substr(0, why.find(':'))) == last_state_) return;
  recorder_.add(McapRun::Note{stamp, mcap_level_of(state), state, why});
}

void McapSink::add(const Frame& frame, const SlamUpdate& update) {
  const std::string detail = update.detail.empty() ? "" : ": " + update.detail;
  add_state(update.stamp, name_of(update.state), name_of(update.reason) + detail);
  for (const SlamEvent& event : update.events)
    recorder_.add(McapRun::Note{update.stamp, mcap_level_of(event.kind), event.kind, event.detail});
  if (update.state != SlamState::initializing) {
    recorder_.add(StampedPose{update.stamp, update.world_from_body});
    online_.push_back({update.stamp, update.world_from_body});
  }
  const bool has_image = !frame.image.empty() || !frame.color.empty();
  if (has_image && has_keyframe(update)) recorder_.add_image(update.stamp, jpeg_of_frame(frame));
}

void McapSink::add(const Frame&, const OdometryUpdate& update) {
  const std::string detail = update.detail.empty() ? "" : ": " + update.detail;
  add_state(update.stamp, name_of(update.state), name_of(update.reason) + detail);
  recorder_.add(StampedPose{update.stamp, update.world_from_camera});
  online_.push_back({update.stamp, update.world_from_camera});
}

void McapSink::finish(const SlamRunEnd& end, TaskPool& pool) { finish(end.map, end.trajectory, pool); }
void McapSink::finish(const OdometryRunEnd& end, TaskPool& pool) { finish(nullptr, end.trajectory, pool); }

void McapSink::finish(std::shared_ptr<const Map> map, const Trajectory& trajectory, TaskPool& pool) {
  constexpr std::size_t most_points = 1'000'000;
  const ExportInput input{out_, std::move(map), trajectory};
  if (trajectory.empty() && (!input.map || input.map->keyframes.empty())) {
    recorder_.finish({});
    return;
  }
  RunRecord record;
  record.online = online_;
  ViewSceneOptions options;
  options.max_points = most_points;
  const McapRun run = mcap_run_of(input, record, view_scene_of(input, record, options, pool, {}), options.submap);
  recorder_.finish(run);
}

std::unique_ptr<McapSink> mcap_sink(const std::string& file, const std::string& out, const std::string& method,
                                    const SourceInfo& source) {
  if (file.empty()) return nullptr;
  return std::make_unique<McapSink>(file, out, method, source);
}

}  // namespace rastro::cli
