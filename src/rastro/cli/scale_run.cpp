// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/scale_run.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/folder_lock.h"
#include "rastro/base/hash.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/export/cloud_image.h"
#include "rastro/export/landmark_image.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/layer_type.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/sensor/trajectory_file.h"
#include "rastro/session/trajectory_text.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct NewFile {
  fs::path file;
  std::string bytes;
};

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

/// As scaled() does with the map.
struct Stretch {
  Eigen::Vector3d fixed;
  double factor;

  double of(double value, std::size_t axis) const {
    const double still = fixed[static_cast<Eigen::Index>(axis)];
    return still + factor * (value - still);
  }
};

/// Moves the three numbers after the timestamp of every line; rotations are kept as they are written.
std::string scaled_trajectory(const std::string& text, const Stretch& stretch, const std::string& where) {
  std::string result;
  for (const std::string_view line : split(text, '\n')) {
    if (line.empty()) continue;
    if (line.starts_with('#')) {
      std::string comment(line);
      for (const std::string unit : {"arbitrary units", "the map's own unit"})  // now and in the last release
        if (const auto at = comment.find(unit); at != std::string::npos) comment.replace(at, unit.size(), "meters");
      result += comment + "\n";
      continue;
    }
    const auto words = split(line, ' ');
    if (words.size() != 8) throw Error("is not the trajectory of a run", where, "scale its map.rastro alone");
    result += words[0];
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto value = parse_finite(words[i]);
      if (!value) throw Error("is not the trajectory of a run", where, "scale its map.rastro alone");
      result += i <= 3 ? fmt::format(" {:.9f}", stretch.of(*value, i - 1)) : fmt::format(" {}", words[i]);
    }
    result += '\n';
  }
  return result;
}

/// A line is a stamp and the upper triangle of a 6x6 matrix, of which the first three rows are of lengths.
std::string scaled_covariances(const std::string& text, double factor, const std::string& where) {
  std::string result;
  for (const std::string_view line : split(text, '\n')) {
    if (line.empty()) continue;
    const auto words = split(line, ' ');
    if (line.starts_with('#')) {
      result += std::string(line) + "\n";
      continue;
    }
    if (words.size() != 22) throw Error("has no covariances of a run", where, "scale its map.rastro alone");
    result += words[0];
    std::size_t next = 1;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        const auto value = parse_finite(words[next++]);
        if (!value) throw Error("has no covariances of a run", where, "scale its map.rastro alone");
        result += fmt::format(" {:.6g}", *value * (row < 3 ? factor : 1.0) * (column < 3 ? factor : 1.0));
      }
    }
    result += '\n';
  }
  return result;
}

std::string scaled_result(const std::string& text, const Map& in_meters, const MapScaleFound& found,
                          const std::string& hash, const std::string& where) {
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_object() || !json.contains("path_length") || !json["path_length"].is_number())
    throw Error("is not the result of a run", where, "scale its map.rastro alone");
  json["path_length"] = std::round(json["path_length"].get<double>() * found.meters_per_unit * 1e4) / 1e4;
  json["scale"] = {
      {"metric", true}, {"relative_sigma", scale_of(in_meters).relative_sigma}, {"from", scale_of(in_meters).origin}};
  json["result_sha256"] = hash;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// As the run drew it.
void write_image(const Map& in_meters, const std::string& file) {
  if (in_meters.layer<SemiDenseLayer>())
    write_cloud_image(layer_points(in_meters, 0, most_drawn_points), trajectory_of(in_meters), file);
  else
    write_landmark_image(in_meters, file);
}

/// Its points are in the map's former unit, its lengths may be in meters already: no factor is right for both.
void set_lengths_aside(const fs::path& folder) {
  const fs::path lengths = folder / "lengths.json", aside = folder / "lengths_before_scale.json";
  if (!is_there(lengths)) return;
  std::error_code code;
  fs::rename(lengths, aside, code);
  if (code) throw Error("cannot be renamed (" + code.message() + ")", lengths.string(), "remove it");
  log_warning(one_line(lengths.string()) +
              ": was measured before in another unit and is lengths_before_scale.json now; "
              "'rastro measure RUN --json' measures anew");
}

}  // namespace

void scale_run_folder(const fs::path& folder, const Map& in_meters, const MapScaleFound& found) {
  const FolderLock lock(folder);
  const Stretch stretch{fixed_point_of(in_meters), found.meters_per_unit};
  std::vector<NewFile> files;
  std::string trajectory, keyframes;
  for (const char* name : {"trajectory.txt", "trajectory_online.txt", "keyframes.txt", "covariance_online.txt"}) {
    const fs::path file = folder / name;
    if (!is_there(file)) continue;
    const std::string text = read_whole_file(file);
    const bool covariance = std::string_view(name).starts_with("covariance");
    files.push_back({file, covariance ? scaled_covariances(text, found.meters_per_unit, file.string())
                                      : scaled_trajectory(text, stretch, file.string())});
    if (std::string_view(name) == "trajectory.txt") trajectory = files.back().bytes;
    if (std::string_view(name) == "keyframes.txt") keyframes = files.back().bytes;
  }
  const fs::path result = folder / "result.json", map = folder / "map.rastro";
  const std::string former_result = is_there(result) ? read_whole_file(result) : "";
  if (!former_result.empty()) scaled_result(former_result, in_meters, found, "", result.string());
  save_map(in_meters, map);
  set_lengths_aside(folder);
  for (const NewFile& file : files) write_whole_file(file.file, file.bytes);
  if (is_there(folder / "map.png")) write_image(in_meters, (folder / "map.png").string());
  if (former_result.empty()) return;
  Sha256 hash;
  hash.add(trajectory);
  hash.add(keyframes);
  hash.add(read_whole_file(map));
  write_whole_file(result, scaled_result(former_result, in_meters, found, hash.finish(), result.string()));
}

}  // namespace rastro::cli
