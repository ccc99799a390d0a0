// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/map/graph/map.h"
#include "rastro/map/images/image_layer.h"

namespace rastro {

/// Where a map that grows is kept safe while the run goes on, and where images go instead of memory. Only how safe a
/// run is may depend on it, never a result.
class MapArchive {
 public:
  virtual ~MapArchive() = default;
  /// Whether a map given to keep() now would be written soon; where not, it need not be put together.
  virtual bool wants_map() const = 0;
  /// Takes the map as it stands, to be written in the background: never waits. Each replaces the one before; about two
  /// a second is written.
  virtual void keep(std::shared_ptr<const Map> map) = 0;
  /// Images of a keyframe, before a map with that keyframe is kept. By one thread at a time.
  virtual void add_images(KeyframeId keyframe, PackedPictures images) = 0;
  /// The images added so far; may be asked by any thread.
  virtual std::shared_ptr<const PictureStore> images() const = 0;
};

}  // namespace rastro
