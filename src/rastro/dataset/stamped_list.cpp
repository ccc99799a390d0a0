// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/stamped_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"

namespace rastro {
namespace {

/// |a - b| without overflow.
std::uint64_t distance(TimeNs a, TimeNs b) {
  return a > b ? static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b)
               : static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a);
}

struct Pair {
  std::uint64_t difference = 0;
  std::size_t from = 0;
  std::size_t to = 0;
};

/// All pairs within the limit, by a sweep over both in order of time.
std::vector<Pair> close_pairs(const std::vector<ListedImage>& from, const std::vector<ListedImage>& to,
                              std::uint64_t limit) {
  std::vector<std::size_t> order(to.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return to[a].stamp < to[b].stamp; });
  constexpr std::size_t most_neighbors = 8;  // On each side; bounds the work on lists of equal stamps.
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto first = std::lower_bound(order.begin(), order.end(), from[i].stamp,
                                        [&](std::size_t k, TimeNs stamp) { return to[k].stamp < stamp; });
    const auto at = static_cast<std::size_t>(first - order.begin());
    const auto add = [&](std::size_t k) {
      const auto difference = distance(from[i].stamp, to[order[k]].stamp);
      if (difference <= limit) pairs.push_back({difference, i, order[k]});
      return difference <= limit;
    };
    for (std::size_t k = at; k < order.size() && k < at + most_neighbors && add(k); ++k) {
    }
    for (std::size_t k = at; k > 0 && k + most_neighbors > at && add(k - 1); --k) {
    }
  }
  return pairs;
}

}  // namespace

ImageList make_image_list(const std::vector<RawListLine>& lines, StampUnit native, std::string_view where) {
  if (lines.empty()) throw Error("lists no image", where, "");
  std::vector<double> rough;
  for (const auto& line : lines) {
    const auto value = parse_finite(line.stamp);
    if (!value)
      throw Error(fmt::format("the stamp {} is not a number", in_quotes(line.stamp)), at_line(where, line.line), "");
    if (line.file.empty()) throw Error("the file name is missing", at_line(where, line.line), "");
    rough.push_back(*value);
  }
  ImageList list;
  list.unit = guess_stamp_unit(rough, native);
  for (const auto& line : lines) {
    const auto stamp = parse_stamp(line.stamp, list.unit);
    if (!stamp) {
      throw Error(fmt::format("the stamp {} is out of range for {}", in_quotes(line.stamp), unit_name(list.unit)),
                  at_line(where, line.line), "");
    }
    list.images.push_back({*stamp, std::string(line.file)});
  }
  return list;
}

std::string unit_warning(StampUnit unit, StampUnit native, std::string_view where) {
  if (unit == native) return "";
  return fmt::format("{}: timestamps look like {}, not {}, and are read as such", where, unit_name(unit),
                     unit_name(native));
}

std::vector<std::int64_t> associate(const std::vector<ListedImage>& from, const std::vector<ListedImage>& to,
                                    TimeNs max_difference) {
  auto pairs = close_pairs(from, to, static_cast<std::uint64_t>(std::max<TimeNs>(max_difference, 0)));
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.difference, a.from, a.to) < std::tie(b.difference, b.from, b.to);
  });
  std::vector<std::int64_t> partner(from.size(), -1);
  std::vector<bool> taken(to.size(), false);
  for (const auto& pair : pairs) {
    if (partner[pair.from] >= 0 || taken[pair.to]) continue;
    partner[pair.from] = static_cast<std::int64_t>(pair.to);
    taken[pair.to] = true;
  }
  return partner;
}

}  // namespace rastro
