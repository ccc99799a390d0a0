// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/cli/export_formats.h"
#include "rastro/cli/keyframe_images.h"
#include "rastro/export/colmap.h"
#include "rastro/export/depth_image.h"
#include "rastro/export/landmark_export.h"
#include "rastro/export/landmark_image.h"
#include "rastro/export/landmarks_csv.h"
#include "rastro/export/pose_graph_g2o.h"
#include "rastro/export/pose_text.h"
#include "rastro/export/word_image.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/map/signatures/signature_layer.h"
#include "rastro/session/trajectory_text.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

/// A map with features and landmarks that they observe.
const Map& need_observed_landmarks(const ExportJob& job) {
  const std::string& kind = job.settings.to;
  const Map& map = need_map(job.input, kind);
  need_layer<LandmarkLayer>(job.input, kind);
  need_layer<FeatureLayer>(job.input, kind);
  return map;
}

std::size_t landmark_count(const Map& map) { return map.layer<LandmarkLayer>()->landmarks.size(); }

/// Writes images/ where the recording of the run is known.
ColmapNames colmap_names(const ExportJob& job, const Map& map) {
  const auto recordings = recordings_of_map(map, job.input.path, job.settings.images);
  const fs::path folder = fs::path(job.settings.out) / "images";
  if (!any_found(recordings)) {
    log_warning(
        "no images are written, and they are named by frame number: the recording of the run was not found; give it "
        "with --images DATA");
    return {};
  }
  return write_keyframe_images(map, job.settings.cloud.submap, recordings, folder);
}

}  // namespace

void write_export(const fs::path& file, std::string_view bytes) {
  write_export(file, [bytes](const PutPiece& put) { put(bytes); });
}

void write_export(const fs::path& file, const std::function<void(const PutPiece&)>& make) {
  std::error_code ignored;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), ignored);
  write_whole_file(file, make);
}

ExportFacts export_g2o(const ExportJob& job) {
  const Map& map = need_map(job.input, "g2o");
  const int submap = job.settings.cloud.submap;
  GraphSize size;
  write_export(job.settings.out, has_observed_landmarks(map) ? landmark_graph_g2o(map, submap, &size)
                                                             : pose_graph_g2o(map, submap, &size));
  return {{"vertices", size.vertices}, {"edges", size.edges}};
}

ExportFacts export_colmap(const ExportJob& job) {
  const Map& map = need_map(job.input, job.settings.to);
  const bool text = job.settings.to == "colmap";
  if (text && map.layer<ImageLayer>())
    return {{"keyframes", write_colmap(map, job.settings.out, job.settings.cloud.submap)}};
  need_observed_landmarks(job);
  const ColmapNames names = colmap_names(job, map);
  const ColmapSize written = write_landmark_colmap(map, job.settings.out, text ? ColmapForm::text : ColmapForm::binary,
                                                   job.settings.cloud.submap, names);
  return {{"keyframes", written.images}, {"images", names.size()}, {"landmarks", written.points}};
}

ExportFacts export_landmark_list(const ExportJob& job) {
  const auto layer = need_layer<LandmarkLayer>(job.input, job.settings.to);
  write_export(job.settings.out, layer->estimates.empty() ? landmark_list_csv(*job.input.map, job.settings.cloud.submap)
                                                          : landmarks_csv(*layer));
  return {{"landmarks", layer->landmarks.size()}};
}

ExportFacts export_image(const ExportJob& job) {
  const Map& map = need_observed_landmarks(job);
  const fs::path out = job.settings.out;
  if (out.extension() != "." + job.settings.to)
    throw Error("the extension does not match the format", out.string(), "give --out FILE." + job.settings.to);
  std::error_code ignored;
  if (out.has_parent_path()) fs::create_directories(out.parent_path(), ignored);
  write_landmark_image(map, out.string());
  return {{"keyframes", map.keyframes.size()}, {"landmarks", landmark_count(map)}};
}

ExportFacts export_word_images(const ExportJob& job) {
  need_layer<SignatureLayer>(job.input, job.settings.to);
  const WordImageCounts counts = write_word_images(*job.input.map, job.settings.out, job.pool, job.progress);
  return {{"locations", counts.locations}, {"loop closures", counts.loop_closures}};
}

ExportFacts export_depth_images(const ExportJob& job) {
  need_layer<SemiDenseLayer>(job.input, job.settings.to);
  return {{"keyframes", write_depth_images(*job.input.map, job.settings.out, job.pool, job.progress)}};
}

ExportFacts export_depth_video(const ExportJob& job) {
  need_layer<SemiDenseLayer>(job.input, job.settings.to);
  const fs::path out = job.settings.out;
  std::error_code ignored;
  if (out.has_parent_path()) fs::create_directories(out.parent_path(), ignored);
  return {{"keyframes", write_depth_video(*job.input.map, out, job.progress)}};
}

ExportFacts export_poses(const ExportJob& job) {
  const Trajectory& trajectory = need_trajectory(job.input, job.settings.to);
  const fs::path out = job.settings.out;
  if (job.settings.to == "tum") write_export(out, trajectory_text(trajectory, "exported; " + unit_of(job.input)));
  if (job.settings.to == "euroc") write_export(out, euroc_text(trajectory));
  if (job.settings.to == "kitti") {
    write_export(out, kitti_text(trajectory));
    write_export(out.parent_path() / (out.stem().string() + "_times.txt"), kitti_times_text(trajectory));
  }
  return {{"poses", trajectory.size()}};
}

}  // namespace rastro::cli
