// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "rastro/map/map_archive.h"

namespace rastro {

class LandmarkKeeper;

/// The map file of a run, written as the run goes: what was added is on its way to the disk within half a second, and a
/// program killed at any moment leaves a file that load_map() reads. When writing fails, the next call says so.
class GrowingMapFile : public MapArchive {
 public:
  /// The file is made with the first thing added after begin(); one that is there before is replaced then.
  explicit GrowingMapFile(std::filesystem::path file);
  /// Without finish() the file stays as far as it came.
  ~GrowingMapFile() override;

  void begin(const RgbdMap& map) override;
  void add_keyframe(const RgbdKeyframe& keyframe, const KeyframePose& pose, PackedPictures pictures) override;
  void add_edge(const PoseEdge& edge) override;
  void set_poses(const std::vector<KeyframePose>& poses) override;
  void add_pose(const StampedPose& world_from_camera) override;
  std::shared_ptr<const PictureStore> pictures() const override;
  void keep(std::shared_ptr<const LandmarkMap> map) override;
  bool wants_map() const override;

  /// Replaces the file by the map as it came to be in the end, which may take its pictures from here; from then on they
  /// are read from that file. Nothing may be added afterwards. May be called without begin().
  void finish(const RgbdMap& map);
  void finish(const LandmarkMap& map);

 private:
  class State;
  std::unique_ptr<State> state_;
  std::unique_ptr<LandmarkKeeper> landmarks_;
};

}  // namespace rastro
