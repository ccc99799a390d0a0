// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/map_figures.h"

#include "rastro/base/task_pool.h"
#include "rastro/base/text_file.h"
#include "rastro/cli/recorded_images.h"
#include "rastro/evaluate/cloud_agreement.h"
#include "rastro/evaluate/length_report.h"
#include "rastro/export/ply.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/images/image_layer.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

void add_agreement(const PointCloud& cloud, const fs::path& truth, TaskPool& pool, RunFigures& figures) {
  if (cloud.points.empty()) return;
  const CloudAgreement agreement = cloud_agreement(read_mesh_ply(truth.string()), cloud, {}, &pool);
  figures["surface_median_m"] = agreement.median;
  figures["surface_complete_percent"] = 100.0 * agreement.completeness;
}

void add_lengths(const Map& map, const fs::path& objects_file, TaskPool& pool, RunFigures& figures) {
  const LengthObjects objects = parse_length_objects(read_text_file(objects_file.string()), objects_file.string());
  if (objects.in_frame_of_ground_truth) return;
  const std::vector<MapOfLengths> measured = {{"", measure_lengths(map, objects.objects, {}, pool)}};
  for (const auto& [name, value] : length_figures(measured)) {
    if (name == "measured") figures["lengths_measured_percent"] = 100.0 * value;
    if (name == "mean_error_m") figures["length_mean_m"] = value;
    if (name == "max_error_m") figures["length_max_m"] = value;
    if (name == "rms_sigmas") figures["length_sigmas"] = value;
  }
  for (const MeasuredLength& length : measured.front().lengths)
    if (const auto error = length.error_m()) figures["length/" + length.name + "_m"] = *error;
}

}  // namespace

void add_map_figures(const fs::path& run_folder, const fs::path& recording, RunFigures& figures) {
  const fs::path truth = recording / "truth.ply", objects = recording / "objects.yaml";
  const fs::path map_file = run_folder / "map.rastro";
  if (!is_file(map_file) || (!is_file(truth) && !is_file(objects))) return;
  TaskPool pool(0);
  auto map = load_map(map_file);
  if (map->keyframes.empty() || map->cameras.empty()) return;
  if (!images_of(*map)) {
    if (map->cameras.front().kind != CameraKind::depth) return;
    map = with_recorded_images(*map, {recording.string(), ""});
  }
  if (is_file(truth)) add_agreement(build_cloud(*map, cloud_options_for(*map), &pool), truth, pool, figures);
  if (is_file(objects)) add_lengths(*map, objects, pool, figures);
}

void add_surface_figures(PointCloud cloud, const Sim3& first_camera_from_cloud, const fs::path& recording,
                         RunFigures& figures) {
  const fs::path truth = recording / "truth.ply";
  if (!is_file(truth)) return;
  for (CloudPoint& point : cloud.points)
    point.position = (first_camera_from_cloud * Eigen::Vector3d(point.position.cast<double>())).cast<float>();
  TaskPool pool(0);
  add_agreement(cloud, truth, pool, figures);
}

}  // namespace rastro::cli
