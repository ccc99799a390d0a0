// SPDX-License-Identifier: Apache-2.0
// Map files: whatever the bytes, they are a map, are refused with one line, or give up what can be saved. Rows are
// tried on their own too, as no mutation of a whole file gets past its checksums.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/map/file/landmark_rows.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/file/map_rows.h"
#include "rastro/map/file/recover_map.h"
#include "rastro/map/landmark/landmark_checks.h"

namespace {

void read_or_refuse(const std::function<void()>& read) {
  try {
    read();
  } catch (const rastro::Error& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos) __builtin_trap();
  }
}

void try_file(std::string_view bytes) {
  static const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("rastro_fuzz_" + std::to_string(::getpid()) + ".rastro");
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  read_or_refuse([] {
    const auto map = rastro::load_map(file);
    if (map->poses.size() != map->keyframes.size()) __builtin_trap();
    for (const auto& keyframe : map->keyframes) map->pictures->pictures(keyframe->id);
  });
  read_or_refuse([] {
    const auto map = rastro::load_landmark_map(file);
    if (!rastro::contradiction_in(*map).empty()) __builtin_trap();
    rastro::covisibility_graph(*map, 1);
  });
  read_or_refuse([] {
    const auto recovered = rastro::recover_map(file);
    if (recovered.landmark_map) {
      if (!rastro::contradiction_in(*recovered.landmark_map).empty()) __builtin_trap();
      return;
    }
    for (const auto& edge : recovered.map->edges)
      if (static_cast<std::size_t>(edge.to) >= recovered.map->keyframes.size()) __builtin_trap();
  });
  std::filesystem::remove(file);
}

void try_rows(std::string_view body) {
  const std::string where = "row";
  rastro::RgbdMap map;
  read_or_refuse([&] { rastro::read_head(body, where, map); });
  read_or_refuse([&] {
    const auto keyframe = rastro::read_keyframe(body, 3, where);
    if (rastro::body_of(*keyframe) != body) __builtin_trap();
  });
  read_or_refuse([&] {
    if (rastro::body_of(rastro::read_pictures(body, where)) != body) __builtin_trap();
  });
  read_or_refuse([&] { rastro::read_pose(body, where); });
  read_or_refuse([&] { rastro::read_edge(body, where); });
  read_or_refuse([&] { rastro::read_stamped_pose(body, where); });
}

void try_landmark_rows(std::string_view body) {
  const std::string where = "row";
  rastro::LandmarkMap map;
  read_or_refuse([&] {
    rastro::read_head(body, where, map);
    if (!rastro::is_landmark_head(body) || rastro::head_body(map) != body) __builtin_trap();
  });
  read_or_refuse([&] {
    if (rastro::body_of(*rastro::read_landmark_keyframe(body, 3, where)) != body) __builtin_trap();
  });
  read_or_refuse([&] {
    if (rastro::body_of(rastro::read_landmark(body, 3, where)) != body) __builtin_trap();
  });
  read_or_refuse([&] { rastro::read_landmark_keyframe_pose(body, where); });
  read_or_refuse([&] { rastro::read_tie(body, where); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (size > 1024 || bytes.starts_with("SQLite")) try_file(bytes);
  try_rows(bytes);
  try_landmark_rows(bytes);
  return 0;
}
