// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <memory>

#include "rastro/feature/descriptor_extractor.h"

namespace rastro::detail {

/// dlib's SURF; throws Error in a build without it.
std::unique_ptr<DescriptorExtractor> make_surf_extractor(const DescriptorExtractorOptions& options);

}  // namespace rastro::detail
