// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/slam_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "rastro/base/append_file.h"
#include "rastro/base/hash.h"
#include "rastro/base/memory.h"
#include "rastro/base/stopwatch.h"
#include "rastro/export/cloud_image.h"
#include "rastro/export/grid_image.h"
#include "rastro/export/grid_map_server.h"
#include "rastro/export/landmark_export.h"
#include "rastro/export/landmark_image.h"
#include "rastro/export/landmarks_csv.h"
#include "rastro/export/place_plot.h"
#include "rastro/export/ply.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/layer_type.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/session/trajectory_text.h"

namespace rastro::cli {
namespace {

bool has_meters(const SlamRunEnd& end) { return !end.result.scale || end.result.scale->metric; }
const char* unit_of(const SlamRunEnd& end) { return has_meters(end) ? "meters" : "arbitrary units"; }

std::string final_poses(const SlamRunEnd& end) {
  return fmt::format("world_from_body of every frame, final; {}", unit_of(end));
}

/// Writes files and hashes them as it goes.
class HashedFiles {
 public:
  explicit HashedFiles(const RunFolder& folder) : folder_(folder) {}
  void write(const std::string& name, const std::string& bytes) {
    write(name, [&bytes](const PutPiece& put) { put(bytes); });
  }
  void write(const std::string& name, const std::function<void(const PutPiece&)>& make) {
    write_whole_file(folder_.file(name), [&](const PutPiece& put) {
      make([&](std::string_view piece) {
        put(piece);
        hash_.add(piece);
      });
    });
    names_.push_back(name);
  }
  /// A file that is there already.
  void add(const std::string& name) {
    std::ifstream stream(folder_.file(name), std::ios::binary);
    std::string piece(1 << 20, '\0');
    while (stream.read(piece.data(), static_cast<std::streamsize>(piece.size())), stream.gcount() > 0)
      hash_.add(std::string_view(piece).substr(0, static_cast<std::size_t>(stream.gcount())));
    names_.push_back(name);
  }
  const std::vector<std::string>& names() const { return names_; }
  std::string finish() { return hash_.finish(); }

 private:
  const RunFolder& folder_;
  Sha256 hash_;
  std::vector<std::string> names_;
};

/// The map of a run with what several files are made from.
struct MapOfRun {
  const Map& map;
  const SlamRunEnd& end;
  std::shared_ptr<const OccupancyGrid> grid;       ///< Null without scans.
  std::shared_ptr<const LandmarkLayer> estimates;  ///< Landmarks of a filter; null without.
  std::optional<PointCloud> cloud;                 ///< Where there are images.
};

MapOfRun map_of(const SlamRunEnd& end) {
  MapOfRun run{*end.map, end, nullptr, end.map->layer<LandmarkLayer>(), std::nullopt};
  if (auto grid = occupancy_grid_of(run.map)) run.grid = std::make_shared<OccupancyGrid>(std::move(*grid));
  if (run.estimates && run.estimates->estimates.empty()) run.estimates = nullptr;
  return run;
}

void write_planar_image(const MapOfRun& run, const std::string& file) {
  MapImage image = map_image(run.map, run.grid, run.end.trajectory);
  // A scan matcher's covariance is of one scan against the map; only the landmark filter has that of the position.
  if (run.estimates)
    for (const PositionCovariance& estimate : run.end.position_covariances)
      image.positions.push_back({estimate.position, estimate.covariance});
  write_map_image(image, file);
}

/// How map.png is made; the first that applies.
struct MapImageFile {
  bool (*applies)(const MapOfRun&);
  void (*write)(const MapOfRun&, const std::string& file);
};
constexpr MapImageFile map_image_files[] = {
    {[](const MapOfRun& run) { return run.cloud.has_value(); },
     [](const MapOfRun& run, const std::string& file) { write_cloud_image(*run.cloud, run.end.trajectory, file); }},
    {[](const MapOfRun& run) { return has_observed_landmarks(run.map); },
     [](const MapOfRun& run, const std::string& file) { write_landmark_image(run.map, file); }},
    {[](const MapOfRun& run) { return run.map.layer<SemiDenseLayer>() != nullptr; },
     [](const MapOfRun& run, const std::string& file) {
       write_cloud_image(layer_points(run.map, 0, most_drawn_points), run.end.trajectory, file,
                         has_meters(run.end) ? "m" : "units");
     }},
    {[](const MapOfRun&) { return true; }, write_planar_image},
};

struct TookTooLong {};

/// A quarter of what is allowed, or half of what is left beside the map and the program: its points and their image
/// come on top; the method is gone. By the map's count, not by what is resident, which differs from run to run: the
/// same run gives the same cloud.
std::size_t bytes_for_cloud(std::size_t max_memory_bytes, std::size_t map_bytes) {
  constexpr std::size_t program_bytes = std::size_t{96} << 20;
  const std::size_t held = std::min(max_memory_bytes, map_bytes + program_bytes);
  return std::min(max_memory_bytes / 4, (max_memory_bytes - held) / 2);
}

/// Coarse enough to be looked at; 'rastro export' makes finer ones from the map file. nullopt: whoever pressed Ctrl-C
/// does not wait that long. Only whether there is one depends on the clock.
std::optional<PointCloud> cloud_of(const Map& map, const SlamContext& context, const SlamResult& result) {
  constexpr double most_ms = 700.0;  // of two seconds for all
  CloudOptions options = cloud_options_for(map);
  if (context.max_memory_bytes > 0) {
    return_freed_memory();
    keep_within(bytes_for_cloud(context.max_memory_bytes, result.memory.map.bytes - result.memory.map.passing_bytes),
                map, options);
  }
  const Stopwatch watch;
  try {
    return build_cloud(map, options, context.pool, [&](std::size_t, std::size_t) {
      if (result.interrupted && watch.elapsed_ms() > most_ms) throw TookTooLong();
    });
  } catch (const TookTooLong&) {
    return std::nullopt;
  }
}

void write_hashed_files(const MapOfRun& run, HashedFiles& files) {
  if (run.grid) {
    files.write("map.pgm", [&run](const PutPiece& put) { map_server_pgm(*run.grid, put); });
    files.write("map.yaml", map_server_yaml(*run.grid, "map.pgm"));
  }
  if (run.estimates) files.write("landmarks.csv", landmarks_csv(*run.estimates));
  if (has_observed_landmarks(run.map)) {
    const std::string comment = fmt::format("world_from_body of keyframes, final; {}", unit_of(run.end));
    files.write("keyframes.txt", trajectory_text(keyframe_trajectory(run.map), comment));
  }
  files.add("map.rastro");
}

std::string size_of(const OccupancyGrid& grid) {
  return fmt::format("{:.1f} x {:.1f} m in cells of {:g} m", grid.width * grid.cell_m, grid.height * grid.cell_m,
                     grid.cell_m);
}

std::string reasons_line(const SlamResult& result) {
  if (result.reasons.empty()) return "";
  std::string text = "  reasons     ";
  for (const auto& [reason, count] : result.reasons) text += fmt::format(" {} {}", reason, count);
  return text + "  (details in events.jsonl)\n";
}

std::string states_line(const SlamResult& result) {
  std::string text = fmt::format("  states       {} tracking", result.states.tracking);
  const std::pair<const char*, std::int64_t> others[] = {{"weak", result.states.weak},
                                                         {"lost", result.states.lost},
                                                         {"relocalized", result.states.relocalized},
                                                         {"initializing", result.states.initializing}};
  for (const auto& [state, count] : others)
    if (count > 0) text += fmt::format(", {} {}", count, state);
  return text + "\n";
}

std::string recall_line(const SlamResult& result) {
  std::string text = fmt::format("  localized    {:.1f} % of the frames", result.recall);
  if (result.seconds_to_first_pose) text += fmt::format(", the first after {:.2f} s", *result.seconds_to_first_pose);
  return text + "\n";
}

std::string map_line(const SlamRunEnd& end, const SlamOutputs& outputs) {
  const SlamResult& result = end.result;
  std::string text = fmt::format("  map          path {:.2f} {}", result.path_length, has_meters(end) ? "m" : "units");
  if (!outputs.grid.empty()) text += ", " + outputs.grid;
  if (result.landmarks > 0) text += fmt::format(", {} landmarks", result.landmarks);
  if (result.keyframes > 0) text += fmt::format(", {} keyframes", result.keyframes);
  if (result.submaps > 1) text += fmt::format(" in {} submaps", result.submaps);
  return text + fmt::format(", {} loop closures\n", result.loops_closed);
}

std::string scale_line(const SlamResult& result) {
  if (!result.scale) return "";
  if (!result.scale->metric)
    return "  scale        arbitrary: the map is up to scale; 'rastro scale' makes it metric\n";
  std::string text = fmt::format("  scale        meters, from {}", result.scale->origin);
  if (result.scale->relative_sigma > 0.0)
    text += fmt::format(" (sigma {:.2g} %)", 100.0 * result.scale->relative_sigma);
  return text + "\n";
}

std::string time_line(const SlamResult& result) {
  std::string text = fmt::format("  time         {:.2f} ms per frame, 95 % within {:.2f} ms",
                                 result.timing.frames.mean_ms(), result.timing.frames.percentile_ms(0.95));
  if (const auto times = result.timing.times_real_time())
    text += fmt::format(", {:.{}f} times real time", *times, *times < 10.0 ? 1 : 0);
  return text + fmt::format("; memory {:.0f} MB\n", result.memory.peak_mb);
}

std::string live_line(const SlamResult& result) {
  return result.timing.live ? "  live         " + summary_of(*result.timing.live) + "\n" : "";
}

/// Where a budget was given.
std::string map_memory_line(const MapMemory& memory) {
  if (memory.budget_bytes == 0) return "";
  constexpr double bytes_per_mb = 1e6;
  std::string text =
      fmt::format("  map memory   {:.1f} MB of {:.1f} MB", static_cast<double>(memory.bytes) / bytes_per_mb,
                  static_cast<double>(memory.budget_bytes) / bytes_per_mb);
  if (!memory.measures.empty()) text += "; " + memory.measures;
  return text + "\n";
}

}  // namespace

SlamOutputs write_slam_outputs(SlamRunEnd& end, const RunFolder& folder, const SlamContext& context, SlamTask task) {
  HashedFiles files(folder);
  SlamOutputs outputs;
  files.write("trajectory.txt", trajectory_text(end.trajectory, final_poses(end)));
  if (task == SlamTask::map && end.map) {
    MapOfRun run = map_of(end);
    write_hashed_files(run, files);
    outputs.files = files.names();
    if (run.grid) outputs.grid = size_of(*run.grid);
    if (images_of(run.map)) run.cloud = cloud_of(run.map, context, end.result);
    outputs.lacks_cloud = images_of(run.map) && !run.cloud;
    if (run.cloud) {
      write_whole_file(folder.file("cloud.ply"),
                       [&run](const PutPiece& put) { cloud_ply(*run.cloud, "world", {}, put); });
      outputs.files.push_back("cloud.ply");
    }
    const MapImageFile& image = *std::find_if(std::begin(map_image_files), std::end(map_image_files),
                                              [&run](const MapImageFile& each) { return each.applies(run); });
    image.write(run, folder.file("map.png").string());
    outputs.files.push_back("map.png");
    if (!end.places.empty()) {
      write_place_plot(end.places, folder.file("places.png").string());
      outputs.files.push_back("places.png");
    }
  } else {
    outputs.files = files.names();
  }
  end.result.result_sha256 = files.finish();
  end.result.memory.peak_mb = std::max(end.result.memory.peak_mb, peak_resident_memory_mb());
  return outputs;
}

std::string slam_summary(const SlamRunEnd& end, const SlamOutputs& outputs, const std::string& folder, SlamTask task) {
  const SlamResult& result = end.result;
  std::string text = fmt::format("{}: {} frames, {:.1f} % of the requested ones have a pose{}\n", result.method.name,
                                 result.frames, result.coverage, result.interrupted ? " (interrupted)" : "");
  if (!result.method.choice.empty()) text += fmt::format("  method       {}\n", result.method.choice);
  text += states_line(result) + reasons_line(result);
  text += (task == SlamTask::localize ? recall_line(result) : map_line(end, outputs)) + scale_line(result) +
          time_line(result) + live_line(result) + map_memory_line(result.memory.map);
  if (result.timing.dropped_frames > 0)
    text += fmt::format("  dropped      {} frames were not mapped because mapping was too slow\n",
                        result.timing.dropped_frames);
  for (const InputWarning& warning : result.warnings) text += fmt::format("  warning      {}\n", warning.text);
  if (outputs.lacks_cloud)
    text +=
        fmt::format("  cloud        left out after the interruption: 'rastro export {} --to ply --out FILE'\n", folder);
  text += fmt::format("  result       sha256 {}\n", result.result_sha256);
  text += fmt::format("written to {}: {} result.json stats.csv\n", folder, fmt::join(outputs.files, " "));
  if (result.skipped_frames > 0) {
    text += fmt::format("warning: {} frames could not be read and were skipped; the first: {}\n", result.skipped_frames,
                        end.first_skip);
  }
  return text;
}

}  // namespace rastro::cli
