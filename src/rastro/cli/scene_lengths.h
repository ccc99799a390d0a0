// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/cli/export_input.h"
#include "rastro/map/graph/map.h"
#include "rastro/viewer/scene.h"

namespace rastro::cli {

/// Named lengths to show with an input: those of the file `objects` (as of `rastro measure`; empty: none), measured in
/// its map, then those of lengths.json in the folder of the run (of `rastro measure --json`). What could not be
/// measured is warned of, and left out. Error for a file that is damaged, and for objects where the map has no depth
/// images.
std::vector<SceneLength> lengths_of(const ExportInput& input, const std::string& objects, TaskPool& pool);

/// One length as a page asks for it, "kind=edges&a=x,y,z&a_direction=x,y,z&a_face=x,y,z&b=...": JSON with `length`,
/// `sigma`, `a`, `b` and `note`, or with `problem`. `kind`: edges or planes, whose directions are their normals.
std::string measured_as_json(const Map& map, std::string_view query, TaskPool& pool);

/// The same as a function that keeps the map; empty where that has no depth images. `threads` as of TaskPool.
std::function<std::string(std::string_view)> measuring_in(const ExportInput& input, int threads);

}  // namespace rastro::cli
