// SPDX-License-Identifier: Apache-2.0
// Map files: whatever the bytes, they are a map, are refused with one line, or can be recovered in part. Rows are
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
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/file/graph_rows.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/file/recover_map.h"
#include "rastro/map/graph/covisibility.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/map/signatures/signature_layer.h"
#include "rastro/map/words/word_layer.h"

namespace {

void read_or_refuse(const std::function<void()>& read) {
  try {
    read();
  } catch (const rastro::Error& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos) __builtin_trap();
  }
}

/// A map that was read is consistent.
void check(const rastro::Map& map) {
  if (!rastro::contradiction_in(map).empty()) __builtin_trap();
  rastro::covisibility_graph(map, 1);
  rastro::trajectory_of(map);
  rastro::layer_points(map, -1);
  for (const auto& [name, layer] : map.layers.all())
    if (const auto* type = rastro::layer_type(name)) type->describe(map, *layer);
  if (const auto images = map.layer<rastro::ImageLayer>())
    for (const rastro::KeyframeId id : images->keyframes) images->store->read(id);
  if (const auto signatures = map.layer<rastro::SignatureLayer>())
    for (const rastro::KeyframeId id : signatures->keyframes) signatures->store->read(id);
}

void try_file(std::string_view bytes) {
  static const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("rastro_fuzz_" + std::to_string(::getpid()) + ".rastro");
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  read_or_refuse([] { check(*rastro::load_map(file)); });
  read_or_refuse([] { check(*rastro::recover_map(file).map); });
  std::filesystem::remove(file);
}

void try_rows(std::string_view body) {
  const std::string where = "row";
  read_or_refuse([&] {
    rastro::Map map;
    rastro::read_head(body, where, map);
    if (!rastro::is_layered_head(body) || rastro::head_body(map) != body) __builtin_trap();
  });
  read_or_refuse([&] {
    if (rastro::body_of(rastro::read_session(body, where)) != body) __builtin_trap();
  });
  read_or_refuse([&] { rastro::read_camera(body, where); });
  read_or_refuse([&] { rastro::read_keyframe(body, 3, where); });
  read_or_refuse([&] { rastro::read_constraint(body, where); });
  read_or_refuse([&] { rastro::read_frame(body, where); });
}

/// A header and a row that are taken are written as they were.
template <typename L>
void try_layer(std::string_view bytes) {
  const std::string where = "layer";
  const rastro::LayerType& type = *rastro::layer_type(L::layer_name);
  const std::string header = type.header(L());
  read_or_refuse([&] {
    const auto layer = type.make(bytes, where);
    if (!header.empty() && type.header(*layer) != bytes) __builtin_trap();
  });
  read_or_refuse([&] {
    const auto layer = type.make(header, where);
    type.read(*layer, 3, bytes, where);
    if (type.row(*layer, 3) != bytes) __builtin_trap();
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (size > 1024 || bytes.starts_with("SQLite")) try_file(bytes);
  try_rows(bytes);
  try_layer<rastro::FeatureLayer>(bytes);
  try_layer<rastro::ImageLayer>(bytes);
  try_layer<rastro::LandmarkLayer>(bytes);
  try_layer<rastro::ScanLayer>(bytes);
  try_layer<rastro::SemiDenseLayer>(bytes);
  try_layer<rastro::WordLayer>(bytes);
  return 0;
}
