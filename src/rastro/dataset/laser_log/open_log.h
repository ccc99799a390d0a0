// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/dataset/open.h"

namespace rastro {

/// A log whose frames are laser scans or landmarks rather than image files; nullptr where `path` looks like none.
/// A folder is one where it holds a scans.log.
std::unique_ptr<Source> open_log(const std::string& path, const OpenOptions& options);

}  // namespace rastro
