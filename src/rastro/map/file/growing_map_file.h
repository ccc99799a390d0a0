// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "rastro/map/map_archive.h"

namespace rastro {

/// The map file of a run, written during the run by a thread of its own: the changes since the last write, in one
/// transaction, about twice a second, and for each new keyframe where that takes little time. A program killed at any
/// moment leaves a file that load_map() reads. A failed write is reported by the next call.
class GrowingMapFile : public MapArchive {
 public:
  /// The file is created with the first data kept; an existing one is replaced then. `recording`: of the newest
  /// session, where the maps do not say it; empty: unknown.
  explicit GrowingMapFile(std::filesystem::path file, std::string recording = {});
  /// Without finish() the file keeps what was written so far.
  ~GrowingMapFile() override;

  bool wants_map() const override;
  void keep(std::shared_ptr<const Map> map) override;
  void add_images(KeyframeId keyframe, PackedImages images) override;
  std::shared_ptr<const ImageStore> images() const override;
  void add_row(const std::string& layer, KeyframeId keyframe, const std::string& body) override;
  std::shared_ptr<const RowStore> rows(const std::string& layer) const override;

  /// Replaces the file by the final map, which may take its images from here; from then on they are read from that
  /// file. Nothing may be added afterwards. May be called without anything kept before.
  void finish(const Map& map);

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
