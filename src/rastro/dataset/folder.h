// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace rastro {

bool is_file(const std::filesystem::path& path);
bool is_folder(const std::filesystem::path& path);

/// Error for what is not a folder or may not be listed, saying which.
void require_folder(const std::filesystem::path& path);

/// Order of people: runs of digits compare as numbers ("2.png" before "10.png").
bool natural_less(std::string_view a, std::string_view b);

/// Whether OpenCV reads this kind of file, by the ending of its name.
bool has_image_ending(const std::filesystem::path& path);
bool has_video_ending(const std::filesystem::path& path);

/// Names (not paths) of the images in a folder, in natural order; empty where the folder does not exist.
std::vector<std::string> image_names(const std::filesystem::path& folder);

/// Names of the folders in a folder, in natural order.
std::vector<std::string> folder_names(const std::filesystem::path& folder);

/// Shell pattern of one name: '*', '?' and [a-z].
bool matches_pattern(std::string_view name, std::string_view pattern);

}  // namespace rastro
