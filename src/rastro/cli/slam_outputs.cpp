// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/slam_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "rastro/base/append_file.h"
#include "rastro/base/hash.h"
#include "rastro/export/cloud_picture.h"
#include "rastro/export/grid_map_server.h"
#include "rastro/export/grid_picture.h"
#include "rastro/export/landmark_picture.h"
#include "rastro/export/landmarks_csv.h"
#include "rastro/export/ply.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/session/trajectory_text.h"

namespace rastro::cli {
namespace {

bool has_metres(const SlamRunEnd& end) { return !end.result.scale || end.result.scale->metric; }
const char* unit_of(const SlamRunEnd& end) { return has_metres(end) ? "metres" : "the map's own unit"; }

std::string final_poses(const SlamRunEnd& end) {
  return fmt::format("world_from_body of every frame with what was learnt later; {}", unit_of(end));
}

/// Of the keyframes of the map's first part, in the order of time.
Trajectory keyframes_of(const LandmarkMap& map) {
  Trajectory trajectory;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k)
    if (map.poses[k].submap == 0) trajectory.push_back({map.keyframes[k]->stamp, map.poses[k].world_from_camera});
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  return trajectory;
}

/// Writes files and hashes them as it goes.
class HashedFiles {
 public:
  explicit HashedFiles(const RunFolder& folder) : folder_(folder) {}
  void write(const std::string& name, const std::string& bytes) {
    write_whole_file(folder_.file(name), bytes);
    hash_.add(bytes);
  }
  /// A file that is there already.
  void add(const std::string& name) {
    std::ifstream stream(folder_.file(name), std::ios::binary);
    std::string piece(1 << 20, '\0');
    while (stream.read(piece.data(), static_cast<std::streamsize>(piece.size())), stream.gcount() > 0)
      hash_.add(std::string_view(piece).substr(0, static_cast<std::size_t>(stream.gcount())));
  }
  std::string finish() { return hash_.finish(); }

 private:
  const RunFolder& folder_;
  Sha256 hash_;
};

void write_picture(const SlamRunEnd& end, const RunFolder& folder) {
  MapPicture picture = map_picture(*end.map, end.trajectory);
  // A matcher's covariance is of one scan against the map; only a filter over landmarks knows that of the place.
  if (!end.map->landmarks.empty())
    for (const PlaceCovariance& place : end.places) picture.places.push_back({place.place, place.covariance});
  write_map_picture(picture, folder.file("map.png").string());
}

/// Coarse enough to be looked at; 'rastro export' makes finer ones from the map file.
void write_cloud(const SlamRunEnd& end, const RunFolder& folder, const SlamMeans& means) {
  constexpr std::size_t bytes_a_voxel = 256;  // with room to grow; half of what is allowed is left to the rest
  CloudOptions options;
  if (means.max_memory_bytes > 0)
    options.max_voxels = std::min(options.max_voxels, means.max_memory_bytes / 2 / bytes_a_voxel + 1);
  const PointCloud cloud = build_cloud(*end.map->rgbd, options, means.pool);
  write_whole_file(folder.file("cloud.ply"), cloud_ply(cloud, "world"));
  write_cloud_picture(cloud, end.trajectory, folder.file("map.png").string());
}

std::string reasons_line(const SlamResult& result) {
  if (result.reasons.empty()) return "";
  std::string text = "  reasons     ";
  for (const auto& [reason, count] : result.reasons) text += fmt::format(" {} {}", reason, count);
  return text + "  (events.jsonl says where, with the numbers)\n";
}

std::string states_line(const SlamResult& result) {
  std::string text = fmt::format("  states       {} tracking", result.tracking);
  const std::pair<const char*, std::int64_t> others[] = {{"weak", result.weak},
                                                         {"lost", result.lost},
                                                         {"relocalised", result.relocalised},
                                                         {"initialising", result.initialising}};
  for (const auto& [state, count] : others)
    if (count > 0) text += fmt::format(", {} {}", count, state);
  return text + "\n";
}

std::string recall_line(const SlamResult& result) {
  std::string text = fmt::format("  in the map   {:.1f} % of the frames", result.recall);
  if (result.seconds_to_first_pose) text += fmt::format(", the first after {:.2f} s", *result.seconds_to_first_pose);
  return text + "\n";
}

std::string map_line(const SlamRunEnd& end) {
  const SlamResult& result = end.result;
  std::string text = fmt::format("  map          path {:.2f} {}", result.path_length, has_metres(end) ? "m" : "units");
  if (end.map && end.map->grid) {
    const OccupancyGrid& grid = *end.map->grid;
    text += fmt::format(", {:.1f} x {:.1f} m in cells of {:g} m", grid.width * grid.cell_m, grid.height * grid.cell_m,
                        grid.cell_m);
  }
  if (result.landmarks > 0) text += fmt::format(", {} landmarks", result.landmarks);
  if (result.keyframes > 0) text += fmt::format(", {} keyframes", result.keyframes);
  if (result.submaps > 1) text += fmt::format(" in {} submaps", result.submaps);
  return text + fmt::format(", {} loops closed\n", result.loops_closed);
}

std::string scale_line(const SlamResult& result) {
  if (!result.scale) return "";
  if (!result.scale->metric)
    return "  scale        arbitrary: lengths are in a unit of the map's own; 'rastro scale' makes them metres\n";
  std::string text = fmt::format("  scale        metres, from {}", result.scale->origin);
  if (result.scale->relative_sigma > 0.0)
    text += fmt::format(" (sigma {:.2g} %)", 100.0 * result.scale->relative_sigma);
  return text + "\n";
}

std::string time_line(const SlamResult& result) {
  std::string text = fmt::format("  time         {:.2f} ms a frame, 95 % within {:.2f} ms",
                                 result.frame_times.mean_ms(), result.frame_times.percentile_ms(0.95));
  if (const auto times = result.times_real_time()) text += fmt::format(", {:.0f} times real time", *times);
  return text + fmt::format("; memory {:.0f} MB\n", result.peak_memory_mb);
}

std::string files_line(const SlamRunEnd& end, const std::string& folder, SlamTask task) {
  if (task == SlamTask::localize) return fmt::format("written to {}: trajectory.txt result.json stats.csv\n", folder);
  std::string text = fmt::format("written to {}: trajectory.txt", folder);
  if (end.map && end.map->grid) text += " map.pgm map.yaml";
  if (end.map && end.map->rgbd) text += " map.rastro cloud.ply";
  if (end.map && end.map->landmark_map) text += " keyframes.txt map.rastro";
  if (end.map) text += " map.png";
  if (end.map && !end.map->landmarks.empty()) text += " landmarks.csv";
  return text + " result.json stats.csv\n";
}

}  // namespace

void write_slam_outputs(SlamRunEnd& end, const RunFolder& folder, const SlamMeans& means, SlamTask task) {
  HashedFiles files(folder);
  files.write("trajectory.txt", trajectory_text(end.trajectory, final_poses(end)));
  if (task == SlamTask::localize) {
    end.result.result_sha256 = files.finish();
    return;
  }
  if (end.map && end.map->grid) {
    files.write("map.pgm", map_server_pgm(*end.map->grid));
    files.write("map.yaml", map_server_yaml(*end.map->grid, "map.pgm"));
  }
  if (end.map && !end.map->landmarks.empty()) files.write("landmarks.csv", landmarks_csv(end.map->landmarks));
  if (end.map && end.map->rgbd) {
    files.add("map.rastro");
    write_cloud(end, folder, means);
  } else if (end.map && end.map->landmark_map) {
    const LandmarkMap& map = *end.map->landmark_map;
    files.write("keyframes.txt",
                trajectory_text(keyframes_of(map),
                                fmt::format("world_from_body of keyframes, as it came to be; {}", unit_of(end))));
    files.add("map.rastro");
    write_landmark_picture(map, folder.file("map.png").string());
  } else if (end.map) {
    write_picture(end, folder);
  }
  end.result.result_sha256 = files.finish();
}

std::string slam_summary(const SlamRunEnd& end, const std::string& folder, SlamTask task) {
  const SlamResult& result = end.result;
  std::string text = fmt::format("{}: {} frames, {:.1f} % of those asked for have a pose{}\n", result.method,
                                 result.frames, result.coverage, result.interrupted ? " (interrupted)" : "");
  text += states_line(result) + reasons_line(result);
  text += (task == SlamTask::localize ? recall_line(result) : map_line(end)) + scale_line(result) + time_line(result);
  text += fmt::format("  result       sha256 {}\n", result.result_sha256) + files_line(end, folder, task);
  if (result.skipped_frames > 0) {
    text += fmt::format("warning: {} frames could not be read and were skipped, the first because: {}\n",
                        result.skipped_frames, end.first_skip);
  }
  return text;
}

}  // namespace rastro::cli
