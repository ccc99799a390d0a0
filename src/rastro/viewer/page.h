// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "rastro/viewer/scene.h"

namespace rastro {

/// The viewer page: one HTML document that needs nothing else (web/dist/viewer.html, packed into the program).
std::string_view viewer_page();

/// The page with scenes in it, as a document that opens without a server; `put` gets it piece by piece.
void put_page_with_scenes(std::span<const NamedScene> scenes, const std::function<void(std::string_view)>& put);

}  // namespace rastro
