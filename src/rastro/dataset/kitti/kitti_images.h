// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "rastro/dataset/recording.h"

namespace rastro {

/// The number that a file is named by ("000012.png" is 12); -1 where the name is not a number.
std::int64_t file_number(const std::string& name);

/// For each image, the row of a list with `row_count` rows that belongs to it: the number in its name where all of them
/// are rows (a clip cut out of a sequence keeps its numbers), else its index in the folder; -1 where there is no such
/// row.
std::vector<std::int64_t> rows_of_images(const std::vector<std::string>& names, std::size_t row_count);

/// The right camera of KITTI's left one: image_1 of image_0, image_3 of image_2; "" for a right one. Also image_00,
/// image_01, ...
std::string kitti_right_of(const std::string& camera);

/// Frames for the images of `folder`, with images of the same name (but for its ending) in `right_folder` where there
/// are any.
std::vector<RecordedFrame> kitti_frames(const std::filesystem::path& folder, const std::filesystem::path& right_folder,
                                        const std::vector<std::string>& names);

/// Says in info what the right camera has, from the frames; a warning where its folder has images, but not for all.
void describe_right(Recording& recording, const std::string& right, const std::filesystem::path& right_folder);

}  // namespace rastro
