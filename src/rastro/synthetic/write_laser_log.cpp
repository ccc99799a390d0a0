// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/write_laser_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/sensor/scan_text.h"
#include "rastro/sensor/stamp_text.h"
#include "rastro/synthetic/floor_plan.h"
#include "rastro/synthetic/recording_files.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t scans_at_once = 64;
enum Stream : std::uint64_t { scan_noise = 11, wheel_noise = 12, landmark_noise = 13 };

std::string seconds_text(TimeNs stamp) { return fmt::format("{}.{:09}", stamp / ns_per_second, stamp % ns_per_second); }

constexpr const char* readme =
    "A robot with a 2D laser in a generated office. Meters, radians, seconds; the world is the robot's start pose,\n"
    "x ahead, y left. The body is the center of its axle.\n"
    "scans.log            CARMEN log: one ROBOTLASER1 line per scan, with wheel odometry; range 0: broken "
    "beam\n"
    "groundtruth.txt      true poses of the body (TUM: stamp x y z qx qy qz qw)\n"
    "relations.txt        true relative poses of scans: stamp stamp x y z roll pitch yaw, of the second in the frame "
    "of the "
    "first\n"
    "floor_plan.pgm/.yaml true plan at the laser's height as far as the laser can see it, glass included (map_server)\n"
    "landmarks.txt        observed door posts (landmark STAMP ID RANGE BEARING) and the odometry (odometry STAMP "
    "FORWARD "
    "TURN)\n"
    "landmarks_truth.csv  positions of those posts\n";

class Recorder {
 public:
  Recorder(const LaserWorld& world, const fs::path& folder, const LaserLogOptions& options)
      : world_(world),
        scans_(std::min(options.scans.value_or(world.scan_count()), world.scan_count())),
        wheels_(options.odometry, seed_for(world.seed, wheel_noise)) {
    if (scans_ < 1) throw Error("there are no scans to write", "frames", "request at least one");
    // Written at the end: an interrupted recording has none of these.
    lock_.emplace(claim_folder(folder, options.force,
                               {"relations.txt", "landmarks_truth.csv", "floor_plan.pgm", "floor_plan.yaml"}));
    TextFile(folder / "README.txt", readme);
    log_.emplace(folder / "scans.log", carmen_header());
    ground_truth_.emplace(folder / "groundtruth.txt", "# world_from_body: stamp tx ty tz qx qy qz qw\n");
    landmarks_.emplace(folder / "landmarks.txt",
                       "# odometry STAMP FORWARD TURN: m/s and rad/s until the next one\n"
                       "# landmark STAMP ID RANGE BEARING: m and rad, from the body\n");
  }

  void record(TaskPool& pool, const std::function<void(std::int64_t)>& progress) {
    for (std::int64_t first = 0; first < scans_; first += scans_at_once) {
      const std::int64_t end = std::min(scans_, first + scans_at_once);
      std::vector<LaserScan> scans(static_cast<std::size_t>(end - first));
      std::vector<std::vector<LandmarkMeasurement>> observations(scans.size());
      pool.for_chunks(0, static_cast<int>(end - first), 1, [&](int begin, int stop) {
        for (int i = begin; i < stop; ++i) {
          scans[static_cast<std::size_t>(i)] = scan(first + i);
          observations[static_cast<std::size_t>(i)] = sight_landmarks(world_, first + i);
        }
      });
      for (std::int64_t number = first; number < end; ++number)
        write(number, scans[static_cast<std::size_t>(number - first)],
              observations[static_cast<std::size_t>(number - first)]);
      if (progress) progress(end);
    }
  }

  std::int64_t scans() const { return scans_; }
  LaserLogSummary summary() const {
    LaserLogSummary result;
    result.scans = scans_;
    result.path_m = path_m_;
    result.odometry_off_m = off_m_;
    result.bytes = bytes_;
    return result;
  }

 private:
  SE2 pose(std::int64_t scan) const { return world_.world_from_body(world_.time_of(scan)); }
  LaserScan scan(std::int64_t number) const {
    const Scene now = world_.scene->at(world_.time_of(number));
    const std::uint64_t stream = seed_for(world_.seed, scan_noise);
    return scan_level(now, world_.panes, world_.laser, pose(number),
                      Random(seed_for(stream, static_cast<std::uint64_t>(number))));
  }

  void write(std::int64_t number, const LaserScan& scan, const std::vector<LandmarkMeasurement>& observations) {
    const SE2 here = pose(number);
    if (number > 0) move(number, pose(number - 1).inverse() * here);
    const std::string line = carmen_robot_laser_line(scan, wheels_.odometry_from_body(), world_.stamp(number));
    log_->write(line);
    bytes_ += line.size();
    const double half = 0.5 * here.rotation().angle();
    const std::string stamp = seconds_text(world_.stamp(number));
    ground_truth_->write(fmt::format("{} {:.9f} {:.9f} 0 0 0 {:.12f} {:.12f}\n", stamp, here.translation().x(),
                                     here.translation().y(), std::sin(half), std::cos(half)));
    for (const LandmarkMeasurement& seen : observations)
      landmarks_->write(fmt::format("landmark {} {} {:.4f} {:.5f}\n", stamp, seen.id, seen.range, seen.bearing));
  }

  void move(std::int64_t number, const SE2& before_from_body) {
    const SE2 before = wheels_.odometry_from_body();
    const Eigen::Vector3d counted = world_.rate_hz * (before.inverse() * wheels_.move(before_from_body)).log();
    landmarks_->write(
        fmt::format("odometry {} {:.6f} {:.6f}\n", seconds_text(world_.stamp(number - 1)), counted.x(), counted.z()));
    path_m_ += before_from_body.translation().norm();
    off_m_ = std::max(off_m_, (wheels_.odometry_from_body().translation() - pose(number).translation()).norm());
  }

  const LaserWorld& world_;
  std::int64_t scans_;
  WheelOdometry wheels_;
  std::optional<FolderLock> lock_;
  std::optional<TextFile> log_, ground_truth_, landmarks_;
  double path_m_ = 0.0, off_m_ = 0.0;
  std::uintmax_t bytes_ = 0;
};

std::string relation_line(const LaserWorld& world, const ScanPair& pair) {
  const SE2 motion =
      world.world_from_body(world.time_of(pair.first)).inverse() * world.world_from_body(world.time_of(pair.second));
  return fmt::format("{} {} {:.6f} {:.6f} 0 0 0 {:.6f}\n", seconds_text(world.stamp(pair.first)),
                     seconds_text(world.stamp(pair.second)), motion.translation().x(), motion.translation().y(),
                     motion.rotation().angle());
}

bool in_sight(const LaserWorld& world, const Scene& now, const Eigen::Vector2d& laser, const LaserLandmark& landmark) {
  const Eigen::Vector2d ray = landmark.position - laser;
  const double free = ray.norm() - landmark.radius, height = world.laser.height_m;
  if (free <= 0.0) return true;
  const Eigen::Vector2d direction = ray.normalized();
  return !now.trace({laser.x(), laser.y(), height}, {direction.x(), direction.y(), 0.0}, free);
}

}  // namespace

std::vector<LandmarkMeasurement> sight_landmarks(const LaserWorld& world, std::int64_t scan) {
  constexpr double reach_m = 6.0, range_share = 0.02, bearing_sigma = std::numbers::pi / 180.0;
  const Scene now = world.scene->at(world.time_of(scan));
  const SE2 world_from_body = world.world_from_body(world.time_of(scan));
  const SE2 laser_from_world = (world_from_body * world.laser.body_from_laser).inverse();
  const Eigen::Vector2d laser = laser_from_world.inverse().translation();
  Random random(seed_for(seed_for(world.seed, landmark_noise), static_cast<std::uint64_t>(scan)));
  std::vector<LandmarkMeasurement> observations;
  for (const LaserLandmark& landmark : world.landmarks) {
    const double range_noise = random.normal(), bearing_noise = random.normal();
    const Eigen::Vector2d seen = laser_from_world * landmark.position;
    if (std::abs(std::atan2(seen.y(), seen.x())) > -world.laser.first_angle) continue;
    const Eigen::Vector2d in_body = world_from_body.inverse() * landmark.position;
    if (in_body.norm() > reach_m || !in_sight(world, now, laser, landmark)) continue;
    observations.push_back({landmark.id, in_body.norm() * (1.0 + range_share * range_noise),
                            std::atan2(in_body.y(), in_body.x()) + bearing_sigma * bearing_noise});
  }
  return observations;
}

std::vector<ScanPair> relation_pairs(const LaserWorld& world, std::int64_t scans) {
  constexpr double step_m = 1.0, revisit_step_m = 0.5, near_m = 1.0, away_m = 10.0;
  std::vector<Eigen::Vector2d> positions;
  std::vector<double> path_length = {0.0};
  for (std::int64_t scan = 0; scan < scans; ++scan) {
    positions.push_back(world.world_from_body(world.time_of(scan)).translation());
    if (scan > 0)
      path_length.push_back(path_length.back() + (positions.back() - positions[positions.size() - 2]).norm());
  }
  std::vector<ScanPair> pairs;
  std::size_t last = 0, last_revisit = 0;
  for (std::size_t here = 1; here < positions.size(); ++here) {
    if (path_length[here] - path_length[last] >= step_m) {
      pairs.push_back({static_cast<std::int64_t>(last), static_cast<std::int64_t>(here)});
      last = here;
    }
    if (path_length[here] - path_length[last_revisit] < revisit_step_m) continue;
    last_revisit = here;
    std::optional<std::size_t> nearest;
    for (std::size_t before = 0; before < here && path_length[here] - path_length[before] > away_m; ++before)
      if ((positions[before] - positions[here]).norm() <
          (nearest ? (positions[*nearest] - positions[here]).norm() : near_m))
        nearest = before;
    if (nearest) pairs.push_back({static_cast<std::int64_t>(*nearest), static_cast<std::int64_t>(here)});
  }
  return pairs;
}

LaserLogSummary write_laser_log(const LaserWorld& world, const fs::path& folder, const LaserLogOptions& options,
                                TaskPool& pool, const std::function<void(std::int64_t)>& progress) {
  Recorder recorder(world, folder, options);
  recorder.record(pool, progress);
  LaserLogSummary summary = recorder.summary();
  const std::vector<ScanPair> pairs = relation_pairs(world, recorder.scans());
  std::string relations;
  for (const ScanPair& pair : pairs) relations += relation_line(world, pair);
  TextFile(folder / "relations.txt", relations);
  std::string posts = "# id, x, y\n";
  for (const LaserLandmark& landmark : world.landmarks)
    posts += fmt::format("{},{:.4f},{:.4f}\n", landmark.id, landmark.position.x(), landmark.position.y());
  TextFile(folder / "landmarks_truth.csv", posts);
  write_floor_plan(true_floor_plan(world, recorder.scans(), 0.05, pool), folder);
  summary.relations = static_cast<std::int64_t>(pairs.size());
  return summary;
}

}  // namespace rastro
