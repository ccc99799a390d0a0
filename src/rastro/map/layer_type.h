// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rastro/map/cloud/point_cloud.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// Rows of a layer that stay in a map file and are read on demand. Thread-safe.
class RowStore {
 public:
  virtual ~RowStore() = default;
  /// Error where the row is missing or damaged.
  virtual std::string row(std::int64_t id) const = 0;
};

/// The description of a layer for `rastro info`.
struct LayerDescription {
  std::string text;                                     ///< "1203 landmarks, observed 4.1 times each"
  std::vector<std::pair<std::string, double>> numbers;  ///< For --json.
};

/// A keyframe's part of a layer, cut out with the keyframe.
struct LayerCut {
  std::shared_ptr<const Layer> rest;
  std::string bytes;  ///< Input for paste(); empty: the layer had nothing for the keyframe.
};

/// Saves, reads, checks, repairs, describes and displays one kind of layer. A layer is one table of the map file: a
/// header, and rows with ascending ids, of keyframes or of its own items. Ids and bytes depend on the layer alone.
/// Readers throw Error naming `where` for any invalid bytes.
class LayerType {
 public:
  virtual ~LayerType() = default;
  virtual std::string name() const = 0;  ///< The layer's layer_name: lowercase letters and '_'.

  virtual std::string header(const Layer&) const { return {}; }
  virtual std::vector<std::int64_t> rows(const Layer& layer) const = 0;  ///< Ids, ascending.
  virtual std::string row(const Layer& layer, std::int64_t id) const = 0;
  /// Whether a row is the same in both, so that it need not be written again.
  virtual bool same_row(const Layer& before, const Layer& now, std::int64_t id) const {
    return row(before, id) == row(now, id);
  }

  /// An empty layer, to which read() adds row by row.
  virtual std::shared_ptr<Layer> make(std::string_view header, const std::string& where) const = 0;
  virtual void read(Layer& layer, std::int64_t id, std::string_view body, const std::string& where) const = 0;
  /// For rows too large for memory: attach() is called instead of read(), and only MapArchive writes new ones.
  virtual bool stays_in_file() const { return false; }
  virtual void attach(Layer&, std::shared_ptr<const RowStore>) const {}

  /// As contradiction_in().
  virtual std::string contradiction(const Map&, const Layer&) const { return {}; }
  /// Without references to missing keyframes or features, for a map that lost parts.
  virtual std::shared_ptr<const Layer> repaired(const Map& map, const std::shared_ptr<const Layer>& layer) const = 0;

  virtual LayerDescription describe(const Map& map, const Layer& layer) const = 0;
  /// Adds the layer's surface points in a submap (-1: in all) to a cloud of single points: about `most`, evenly chosen,
  /// where the layer has many more.
  virtual void add_points(const Map&, const Layer&, int /*submap*/, std::size_t /*most*/, PointCloud&) const {}

  /// Removes a keyframe's part, and adds it again.
  virtual LayerCut cut(const Layer& layer, KeyframeId id) const = 0;
  virtual std::shared_ptr<const Layer> paste(const Layer& layer, KeyframeId id, std::string_view bytes) const = 0;
  /// With other ids of keyframes in the same order; `new_id` has all of the map.
  virtual std::shared_ptr<const Layer> renumbered(const std::shared_ptr<const Layer>& layer,
                                                  const std::map<KeyframeId, KeyframeId>& new_id) const = 0;
};

/// All layer types of this program, by name. Generated from the rastro_layer() lines of the build.
const std::vector<std::unique_ptr<LayerType>>& layer_types();
/// Null for an unknown one.
const LayerType* layer_type(std::string_view name);

/// The surface points of all layers in a submap (-1: in all), layer by layer in the order of their names; about `most`
/// of a layer with many more.
PointCloud layer_points(const Map& map, int submap, std::size_t most = std::numeric_limits<std::size_t>::max());

/// A layer unknown to this program: kept unchanged when the file is written again, and left out of maps whose keyframes
/// were removed or renumbered (graph/edit.h).
struct UnknownLayer : Layer {
  std::string header;
  std::vector<std::pair<std::int64_t, std::string>> rows;
};

}  // namespace rastro
