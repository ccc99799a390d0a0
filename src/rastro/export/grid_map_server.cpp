// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/grid_map_server.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"

namespace rastro {
namespace {

constexpr int unknown_gray = 205;
constexpr double occupied_threshold = 0.65, free_threshold = 0.196;
constexpr std::int64_t most_cells = 100'000'000;
constexpr double smallest_cell_m = 1e-3, largest_cell_m = 1e3;
constexpr double farthest_m = 1e5;  ///< With the smallest cell a number of cells that fits an int.

int gray_of(std::int8_t percent) {
  if (percent == OccupancyGrid::unknown) return unknown_gray;
  return 255 - static_cast<int>(std::lround(2.55 * percent));
}

struct PgmImage {
  int width = 0, height = 0;
  std::string_view pixels;  ///< 8-bit gray, the top row first.
};

/// The numbers of a PGM's head, which spaces and comments may stand between.
class Head {
 public:
  Head(std::string_view bytes, std::string_view where) : bytes_(bytes), where_(where) {
    if (!bytes.starts_with("P5")) refuse("is not a binary PGM (P5)");
    position_ = 2;
  }

  std::int64_t number(std::int64_t largest) {
    skip_space();
    const std::size_t begin = position_;
    while (position_ < bytes_.size() && bytes_[position_] >= '0' && bytes_[position_] <= '9') ++position_;
    const auto value = parse_int64(bytes_.substr(begin, position_ - begin));
    if (!value || *value < 1 || *value > largest) refuse("has no valid width, height and maximum value");
    return *value;
  }

  /// What follows the one space after the head.
  std::string_view rest() const { return bytes_.substr(std::min(position_ + 1, bytes_.size())); }

  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(what, where_, "give the 8-bit image that map_server writes");
  }

 private:
  void skip_space() {
    while (position_ < bytes_.size()) {
      if (bytes_[position_] == '#') {
        position_ = std::min(bytes_.find('\n', position_), bytes_.size());
      } else if (std::string_view(" \t\r\n").find(bytes_[position_]) == std::string_view::npos) {
        return;
      } else {
        ++position_;
      }
    }
  }

  std::string_view bytes_, where_;
  std::size_t position_ = 0;
};

PgmImage parse_pgm(std::string_view bytes, std::string_view where) {
  Head head(bytes, where);
  const std::int64_t width = head.number(most_cells), height = head.number(most_cells);
  if (width * height > most_cells) head.refuse("is too large");
  if (head.number(65535) != 255) head.refuse("is not of 256 grays");
  const std::string_view pixels = head.rest();
  if (static_cast<std::int64_t>(pixels.size()) < width * height) {
    head.refuse(fmt::format("ends early: {} of {} cells", pixels.size(), width * height));
  }
  return {static_cast<int>(width), static_cast<int>(height), pixels};
}

struct Thresholds {
  bool negate = false;
  double occupied = occupied_threshold, free = free_threshold;

  std::int8_t percent_of(unsigned char gray) const {
    const double occupancy = (negate ? gray : 255 - gray) / 255.0;
    if (occupancy > occupied) return 100;
    return occupancy < free ? std::int8_t{0} : OccupancyGrid::unknown;
  }
};

/// The keys of a map's yaml; whatever is not as it should be is one line with file, line and key.
class MapFields {
 public:
  MapFields(std::string_view yaml, std::string_view where) : where_(where) {
    if (yaml.starts_with("P5")) throw Error("is the image of a map, not its yaml", where, "give the .yaml beside it");
    try {
      root_ = YAML::Load(std::string(yaml));
    } catch (const YAML::Exception& error) {
      throw Error(fmt::format("not valid YAML: {}", one_line(error.msg)), at_line(where, error.mark.line + 1),
                  expected);
    }
    if (!root_.IsMap()) throw Error("not a map: no 'key: value' lines", where, expected);
  }

  bool has(const char* key) const { return static_cast<bool>(root_[key]); }

  std::string text(const char* key) const {
    if (!has(key)) throw Error(fmt::format("no key '{}'", key), where_, expected);
    if (!root_[key].IsScalar()) fail(key, "is not a single word", "");
    return root_[key].Scalar();
  }

  double number(const char* key) const { return number_in(text(key), key); }

  std::array<double, 3> three_numbers(const char* key) const {
    if (!has(key)) throw Error(fmt::format("no key '{}'", key), where_, expected);
    const YAML::Node list = root_[key];
    if (!list.IsSequence() || list.size() != 3) fail(key, "is not three numbers", "write [x, y, 0]");
    std::array<double, 3> numbers{};
    for (std::size_t k = 0; k < 3; ++k) numbers[k] = number_in(list[k].IsScalar() ? list[k].Scalar() : "?", key);
    return numbers;
  }

  [[noreturn]] void fail(const char* key, const std::string& what, const char* remedy) const {
    throw Error(fmt::format("{} {}", key, what), at_line(where_, root_[key].Mark().line + 1), remedy);
  }

 private:
  static constexpr const char* expected = "expected the .yaml that map_server writes beside an image";

  double number_in(const std::string& word, const char* key) const {
    const auto number = parse_finite(word);
    if (!number) fail(key, fmt::format("is {}, not a number", in_quotes(word)), "");
    return *number;
  }

  YAML::Node root_;
  std::string where_;
};

Thresholds thresholds_of(const MapFields& fields) {
  Thresholds found;
  found.negate = fields.has("negate") && fields.number("negate") != 0.0;
  if (fields.has("occupied_thresh")) found.occupied = fields.number("occupied_thresh");
  if (fields.has("free_thresh")) found.free = fields.number("free_thresh");
  if (fields.has("mode") && fields.text("mode") != "trinary") {
    fields.fail("mode", "is not 'trinary', the only one read", "save the map with map_server's default mode");
  }
  return found;
}

void set_geometry(OccupancyGrid& grid, const MapFields& fields) {
  grid.cell_m = fields.number("resolution");
  if (!(grid.cell_m >= smallest_cell_m && grid.cell_m <= largest_cell_m))
    fields.fail("resolution", "is not a cell size in meters", "");
  const std::array<double, 3> origin = fields.three_numbers("origin");
  grid.origin = {origin[0], origin[1]};
  if (grid.origin.cwiseAbs().maxCoeff() > farthest_m) fields.fail("origin", "is too large", "");
  if (origin[2] != 0.0) fields.fail("origin", "has a rotation, which is not supported", "its third number must be 0");
}

/// The top row of the image is that of the largest y.
void read_cells(const PgmImage& image, const Thresholds& thresholds, OccupancyGrid& grid) {
  TiledCells<std::int8_t>::Writer writer(grid.percent);
  for (int y = 0; y < image.height; ++y) {
    const auto row = static_cast<std::size_t>(image.height - 1 - y) * static_cast<std::size_t>(image.width);
    for (int x = 0; x < image.width; ++x) {
      const char gray = image.pixels[row + static_cast<std::size_t>(x)];
      const std::int8_t percent = thresholds.percent_of(static_cast<unsigned char>(gray));
      if (percent != OccupancyGrid::unknown) writer.at(x, y) = percent;
    }
  }
}

/// A name as YAML reads it back: "floor #1.pgm" would end before the comment. Plain names stay as map_server writes
/// them.
std::string as_yaml(const std::string& name) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  };
  const bool begins_plainly = !name.empty() && name.front() != '-' && name.front() != '.';
  if (begins_plainly && std::all_of(name.begin(), name.end(), is_plain)) return name;
  std::string quoted;
  for (const char c : name) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return "'" + quoted + "'";
}

}  // namespace

std::string map_server_pgm(const OccupancyGrid& grid) {
  std::string bytes;
  map_server_pgm(grid, [&bytes](std::string_view piece) { bytes += piece; });
  return bytes;
}

void map_server_pgm(const OccupancyGrid& grid, const std::function<void(std::string_view)>& put) {
  constexpr std::size_t least_piece = 1 << 20;
  std::string bytes = fmt::format("P5\n{} {}\n255\n", grid.width, grid.height);
  for (int y = grid.height - 1; y >= 0; --y) {
    for (const std::int8_t percent : grid.row(y)) bytes += static_cast<char>(gray_of(percent));
    if (bytes.size() < least_piece) continue;
    put(bytes);
    bytes.clear();
  }
  put(bytes);
}

std::string map_server_yaml(const OccupancyGrid& grid, const std::string& image) {
  return fmt::format(
      "image: {}\nresolution: {:.9g}\norigin: [{:.9g}, {:.9g}, 0]\nnegate: 0\noccupied_thresh: {}\nfree_thresh: {}\n",
      as_yaml(image), grid.cell_m, grid.origin.x(), grid.origin.y(), occupied_threshold, free_threshold);
}

OccupancyGrid parse_map_server(std::string_view yaml, std::string_view where, std::string_view pgm,
                               std::string_view image_file) {
  const MapFields fields(yaml, where);
  const Thresholds thresholds = thresholds_of(fields);
  OccupancyGrid grid;
  set_geometry(grid, fields);
  const PgmImage read = parse_pgm(pgm, image_file);
  grid.width = read.width;
  grid.height = read.height;
  if (std::max(read.width, read.height) * grid.cell_m > farthest_m)
    throw Error("is too large for a map", image_file, "check the resolution");
  read_cells(read, thresholds, grid);
  return grid;
}

OccupancyGrid read_map_server(const std::string& yaml_file) {
  const std::string yaml = read_text_file(yaml_file);
  const MapFields fields(yaml, yaml_file);
  const std::filesystem::path image(fields.text("image"));
  const std::string image_file = (std::filesystem::path(yaml_file).parent_path() / image).string();
  return parse_map_server(yaml, yaml_file, read_text_file(image_file), image_file);
}

}  // namespace rastro
