// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/recorded_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "rastro/base/error.h"
#include "rastro/cli/readable_frames.h"
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

/// Adds the images of the keyframes that are of this recording.
void add_images(const Map& map, const MapRecording& part, MemoryImages& store, ImageLayer& layer) {
  const std::string& path = part.recording.path;
  if (path.empty())
    throw Error(fmt::format("the recording of {} of {} keyframes of the map is gone", part.keyframes.size(),
                            map.keyframes.size()),
                part.named, "give it with --images");
  const auto source = open(path, open_options(map, part.recording));
  check_size(map, source->info());
  const auto rectification = rectification_of(map, source->info());
  std::map<TimeNs, KeyframeId> wanted;
  for (const KeyframeId id : part.keyframes) wanted[map.find(id)->stamp] = id;
  std::size_t missing = wanted.size();
  while (missing > 0) {
    auto frame = next_readable(*source);
    if (!frame) break;
    const auto found = wanted.find(frame->stamp);
    if (found == wanted.end()) continue;
    if (rectification) frame->image = remap(frame->image.view(), rectification->left), frame->color = {};
    store.add(found->second, pack_images(*frame));
    layer.keyframes.push_back(found->second);
    --missing;
  }
  if (missing > 0)
    throw Error(fmt::format("lacks the frames of {} of {} keyframes of the map", missing, wanted.size()), path,
                "is it the recording that the map was made of?");
}

}  // namespace

std::shared_ptr<const Map> with_recorded_images(const Map& map, const std::vector<MapRecording>& recordings) {
  auto store = std::make_shared<MemoryImages>();
  auto layer = std::make_shared<ImageLayer>();
  for (const MapRecording& part : recordings) add_images(map, part, *store, *layer);
  std::sort(layer->keyframes.begin(), layer->keyframes.end());
  layer->store = std::move(store);
  auto whole = std::make_shared<Map>(map);
  whole->layers.put<ImageLayer>(std::move(layer));
  return whole;
}

}  // namespace rastro::cli
