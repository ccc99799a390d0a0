// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "rastro/map/map_archive.h"

namespace rastro {

/// The map file of a run, written as the run goes on a thread of its own: what changed since the last time, in one
/// transaction, about twice a second. A program killed at any moment leaves a file that load_map() reads. When writing
/// fails, the next call says so.
class GrowingMapFile : public MapArchive {
 public:
  /// The file is made with the first thing kept; one that is there before is replaced then.
  explicit GrowingMapFile(std::filesystem::path file);
  /// Without finish() the file stays as far as it came.
  ~GrowingMapFile() override;

  bool wants_map() const override;
  void keep(std::shared_ptr<const Map> map) override;
  void add_images(KeyframeId keyframe, PackedPictures images) override;
  std::shared_ptr<const PictureStore> images() const override;

  /// Replaces the file by the map as it came to be in the end, which may take its images from here; from then on they
  /// are read from that file. Nothing may be added afterwards. May be called without anything kept before.
  void finish(const Map& map);

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
