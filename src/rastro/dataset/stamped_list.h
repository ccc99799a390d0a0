// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {

/// A line of a list of images: when, and which file (as written, relative to the list's folder).
struct ListedImage {
  TimeNs stamp = 0;
  std::string file;
};

struct ImageList {
  std::vector<ListedImage> images;      ///< In the order of the file, even where stamps go backward.
  StampUnit unit = StampUnit::seconds;  ///< What the stamps were taken to be written in.
};

/// A line cut into its stamp and file columns, before the unit of the stamps is known.
struct RawListLine {
  int line = 0;
  std::string_view stamp;
  std::string_view file;
};

/// Turns cut lines into a list: guesses the unit from all stamps together (the format's own is `native`), then reads
/// them exactly. Error naming `where`:line for a stamp that is not a number and for a file column that is empty.
ImageList make_image_list(const std::vector<RawListLine>& lines, StampUnit native, std::string_view where);

/// A warning where the unit is not the format's own; "" otherwise.
std::string unit_warning(StampUnit unit, StampUnit native, std::string_view where);

/// For each of `from`, the index in `to` of the nearest stamp not farther than max_difference, each of `to` used once,
/// nearest pairs first (as the TUM benchmark's associate.py does); -1 where there is none. Stamps may be in any order.
std::vector<std::int64_t> associate(const std::vector<ListedImage>& from, const std::vector<ListedImage>& to,
                                    TimeNs max_difference);

}  // namespace rastro
