// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/map/graph/map.h"
#include "rastro/sensor/trajectory.h"

namespace rastro::cli {

/// What `rastro export` is given: the folder of a run, a map file, or a file of poses.
struct ExportInput {
  std::string path;
  std::shared_ptr<const Map> map;  ///< Null where there is none.
  Trajectory trajectory;           ///< Of every frame with a pose; empty where there is none.
};

/// Error where `path` is none of the three, or cannot be read.
ExportInput read_export_input(const std::string& path);

/// What the lengths of a map are in, or of poses: as the map says, else the comment of the file that they were read
/// from.
std::string unit_of(const Map& map);
std::string unit_of(const ExportInput& input);

/// A map with keyframes, or an Error that says what the input lacks for an export as `kind`.
const Map& need_map(const ExportInput& input, const std::string& kind);
const Trajectory& need_trajectory(const ExportInput& input, const std::string& kind);

/// Says that `path` has no such layer, which `kind` is made from, and which methods make one.
[[noreturn]] void refuse_without_layer(const std::string& path, const std::string& layer, const std::string& kind);

template <typename L>
std::shared_ptr<const L> need_layer(const ExportInput& input, const std::string& kind) {
  auto layer = need_map(input, kind).template layer<L>();
  if (!layer) refuse_without_layer(input.path, L::layer_name, kind);
  return layer;
}

}  // namespace rastro::cli
