// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "rastro/dataset/recording.h"
#include "rastro/dataset/stamped_list.h"

namespace rastro {

/// rgb.txt or depth.txt: "stamp file" a line, seconds. Error naming `where`:line for anything else.
ImageList parse_tum_image_list(std::string_view text, std::string_view where);

struct TumAssociations {
  ImageList color;
  ImageList depth;  ///< Line by line the partner of color.
};

/// associations.txt: "stamp rgb_file stamp depth_file" a line, or the depth first; the names tell which.
TumAssociations parse_tum_associations(std::string_view text, std::string_view where);

/// TUM RGB-D folder (Sturm et al. 2012). nullopt where `path` looks like nothing of the kind.
std::optional<Recording> index_tum_rgbd(const std::filesystem::path& path, const OpenOptions& options);

}  // namespace rastro
