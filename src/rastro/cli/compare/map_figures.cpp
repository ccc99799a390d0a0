// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/map_figures.h"

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/task_pool.h"
#include "rastro/base/text_file.h"
#include "rastro/cli/lengths_scale.h"
#include "rastro/cli/recorded_images.h"
#include "rastro/cli/recording_of_run.h"
#include "rastro/cli/trajectory_files.h"
#include "rastro/evaluate/cloud_agreement.h"
#include "rastro/evaluate/length_report.h"
#include "rastro/export/ply.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/landmarks/map_scale.h"
#include "rastro/map/layer_type.h"

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

LengthObjects objects_in(const fs::path& file) {
  return parse_length_objects(read_text_file(file.string()), file.string());
}

/// Of those whose length is known; empty: none.
std::string longest_of(const std::vector<LengthObject>& objects) {
  const auto longest = std::max_element(objects.begin(), objects.end(), [](const auto& one, const auto& other) {
    return one.true_length_m.value_or(0.0) < other.true_length_m.value_or(0.0);
  });
  return longest == objects.end() || !longest->true_length_m ? std::string() : longest->name;
}

void add_lengths(const Map& map, const LengthObjects& objects, TaskPool& pool, RunFigures& figures) {
  if (objects.in_frame_of_ground_truth) return;
  std::vector<MapOfLengths> measured = {{"", measure_lengths(map, objects.objects, {}, pool)}};
  // One camera does not tell the scale: a known length does, and is no result then.
  const bool has_scale = map.cameras.front().kind != CameraKind::mono;
  apply_known_length(measured.front().lengths, has_scale ? std::string() : longest_of(objects.objects));
  for (const auto& [name, value] : length_figures(measured)) {
    if (!std::isfinite(value)) continue;  // of no length
    if (name == "measured") figures["lengths_measured_percent"] = 100.0 * value;
    if (name == "mean_error_m") figures["length_mean_m"] = value;
    if (name == "max_error_m") figures["length_max_m"] = value;
    if (name == "rms_sigmas") figures["length_sigmas"] = value;
  }
  for (const MeasuredLength& length : measured.front().lengths)
    if (const auto error = length.error_m()) figures["length/" + length.name + "_m"] = *error;
}

/// As 'rastro export --to ply' gives them.
PointCloud surfaces_of(const Map& map, TaskPool& pool) {
  return images_of(map) ? build_cloud(map, cloud_options_for(map), &pool) : layer_points(map, 0);
}

/// With images, and nearly metric, so that the objects are found: the trajectory's scale is replaced later.
std::shared_ptr<const Map> map_to_measure(std::shared_ptr<const Map> map, const fs::path& file,
                                          const fs::path& recording) {
  if (!images_of(*map)) map = with_recorded_images(*map, recordings_of_map(*map, file, recording.string()));
  if (scale_of(*map).metric) return map;
  try {
    const Trajectory ground_truth = poses_of_camera(read_reference(recording.string(), {}));
    const auto session = session_of_reference(*map, file, recording);
    return std::make_shared<const Map>(
        scaled(*map, scale_from_reference(*map, ground_truth, recording.string(), session)));
  } catch (const Error&) {
    return nullptr;  // lost too early for a scale
  }
}

}  // namespace

void add_map_figures(const fs::path& run_folder, const fs::path& recording, RunFigures& figures) {
  const fs::path truth = recording / "truth.ply", objects = recording / "objects.yaml";
  const fs::path map_file = run_folder / "map.rastro";
  if (!is_file(map_file) || (!is_file(truth) && !is_file(objects))) return;
  const auto map = load_map(map_file);
  if (map->keyframes.empty() || map->cameras.empty() || map->cameras.front().kind == CameraKind::none) return;
  TaskPool pool(0);
  if (is_file(truth) && map->cameras.front().kind != CameraKind::mono)
    add_agreement(surfaces_of(*map, pool), truth, pool, figures);
  if (!is_file(objects)) return;
  if (const auto measured = map_to_measure(map, map_file, recording))
    add_lengths(*measured, objects_in(objects), pool, figures);
}

std::string known_length_of_mono_maps(const fs::path& recording) {
  const fs::path objects = recording / "objects.yaml";
  return is_file(objects) ? longest_of(objects_in(objects).objects) : "";
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
