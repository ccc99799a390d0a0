// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/map/graph/map.h"
#include "rastro/map/images/image_layer.h"

namespace rastro {

/// Where a growing map is saved during the run, and where images go instead of memory. Only the safety of a run may
/// depend on it, never a result.
class MapArchive {
 public:
  virtual ~MapArchive() = default;
  /// Whether a map given to keep() now would be written soon; if not, it need not be built. Thread-safe.
  virtual bool wants_map() const = 0;
  /// Takes the current map, to be written in the background: never waits. Each replaces the previous one; about two per
  /// second are written.
  virtual void keep(std::shared_ptr<const Map> map) = 0;
  /// Images of a keyframe, before a map with that keyframe is kept. By one thread at a time.
  virtual void add_images(KeyframeId keyframe, PackedImages images) = 0;
  /// The images added so far. Thread-safe.
  virtual std::shared_ptr<const ImageStore> images() const = 0;
  /// The same for any layer that stays in the file: a row of it, serialized.
  virtual void add_row(const std::string& /*layer*/, KeyframeId /*keyframe*/, const std::string& /*body*/) {}
  /// The rows added so far. Thread-safe. Null: it takes none, and the method keeps them in memory.
  virtual std::shared_ptr<const RowStore> rows(const std::string& /*layer*/) const { return nullptr; }
};

}  // namespace rastro
