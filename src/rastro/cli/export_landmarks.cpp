// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/export_landmarks.h"

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/export/landmark_export.h"
#include "rastro/export/landmark_picture.h"
#include "rastro/export/ply.h"
#include "rastro/map/landmark/essential_graph.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

void write_file(const fs::path& file, std::string_view bytes) {
  std::error_code ignored;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), ignored);
  write_whole_file(file, bytes);
}

void write_picture(const LandmarkMap& map, const std::string& to, const fs::path& out) {
  if (out.extension() != "." + to)
    throw Error("the picture would not have the ending of its kind", out.string(), "give --out FILE." + to);
  std::error_code ignored;
  if (out.has_parent_path()) fs::create_directories(out.parent_path(), ignored);
  write_landmark_picture(map, out.string());
}

}  // namespace

LandmarkExportFacts export_landmarks(const LandmarkMap& map, const std::string& to, const fs::path& out, int submap) {
  const char* unit =
      map.scale.metric ? "frame: the world of the map" : "frame and unit: the world of the map, no metres";
  if (to == "ply") {
    const PointCloud cloud = landmark_cloud(map, submap);
    write_file(out, cloud_ply(cloud, unit));
    return {{"landmarks", cloud.points.size()}};
  }
  if (to == "landmarks") {
    write_file(out, landmark_list_csv(map, submap));
    return {{"landmarks", map.landmarks.size()}};
  }
  if (to == "g2o") {
    write_file(out, landmark_graph_g2o(map, submap));
    return {{"vertices", map.poses.size()}, {"edges", essential_graph(map).size()}};
  }
  if (to == "colmap" || to == "colmap-binary") {
    write_landmark_colmap(map, out, to == "colmap" ? ColmapForm::text : ColmapForm::binary, submap);
    return {{"keyframes", map.keyframes.size()}, {"landmarks", map.landmarks.size()}};
  }
  if (to == "svg" || to == "png") {
    write_picture(map, to, out);
    return {{"keyframes", map.keyframes.size()}, {"landmarks", map.landmarks.size()}};
  }
  throw Error("is made from a map of a depth camera, and this is one of landmarks", "--to " + to,
              "known for landmarks are ply, landmarks, g2o, colmap, colmap-binary, svg, png, tum, kitti, euroc");
}

}  // namespace rastro::cli
