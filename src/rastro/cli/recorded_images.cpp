// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/recorded_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "rastro/base/error.h"
#include "rastro/dataset/open.h"
#include "rastro/map/images/pack_images.h"

namespace rastro::cli {
namespace {

/// What the run saw: depth that it did not use measures nothing in its map.
OpenOptions open_options(const Map& map, const RecordingOfRun& recording) {
  const CameraKind kind = camera_of(map, recording.path).kind;
  if (kind == CameraKind::none) throw Error("is the map of a laser: it has no images", recording.path, "");
  OpenOptions options;
  options.camera = recording.camera;
  options.want_color = true;
  options.want_depth = kind == CameraKind::depth;
  options.want_right = kind == CameraKind::stereo;
  return options;
}

void check_size(const Map& map, const SourceInfo& info) {
  const Camera& camera = camera_of(map, info.path).intrinsics;
  if (info.cameras.empty() || !info.cameras.front().camera) return;
  const Camera& recorded = *info.cameras.front().camera;
  if (recorded.width != 0 && (recorded.width != camera.width || recorded.height != camera.height))
    throw Error("its images are not those of the map's camera", info.path, "is it the recording of the map?");
}

}  // namespace

std::shared_ptr<const Map> with_recorded_images(const Map& map, const RecordingOfRun& recording) {
  const auto source = open(recording.path, open_options(map, recording));
  check_size(map, source->info());
  const auto rectification = rectification_of(map, source->info());
  std::map<TimeNs, KeyframeId> wanted;
  for (const Keyframe& keyframe : map.keyframes) wanted[keyframe.stamp] = keyframe.id;
  auto store = std::make_shared<MemoryImages>();
  auto layer = std::make_shared<ImageLayer>();
  while (layer->keyframes.size() < wanted.size()) {
    auto frame = source->next();
    if (!frame) break;
    const auto found = wanted.find(frame->stamp);
    if (found == wanted.end()) continue;
    if (rectification) frame->image = remap(frame->image.view(), rectification->left), frame->color = {};
    store->add(found->second, pack_images(*frame));
    layer->keyframes.push_back(found->second);
  }
  if (layer->keyframes.size() < wanted.size())
    throw Error(fmt::format("lacks the frames of {} of {} keyframes of the map",
                            wanted.size() - layer->keyframes.size(), wanted.size()),
                recording.path, "is it the recording that the map was made of?");
  std::sort(layer->keyframes.begin(), layer->keyframes.end());
  layer->store = std::move(store);
  auto whole = std::make_shared<Map>(map);
  whole->layers.put<ImageLayer>(std::move(layer));
  return whole;
}

}  // namespace rastro::cli
