// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/landmark_log/open_landmark_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/ground_truth.h"
#include "rastro/dataset/landmark_log/landmark_log.h"
#include "rastro/dataset/recording.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

class LandmarkSource final : public Source {
 public:
  LandmarkSource(SourceInfo info, const LandmarkLog& log, const OpenOptions& options)
      : info_(std::move(info)), frames_(landmark_frames(log)) {
    if (!options.camera.empty()) throw Error("a landmark log has no cameras", "--camera", "omit it");
    if (frames_.empty())
      throw Error("has no landmark observations", info_.path, fmt::to_string(fmt::join(log.warnings, "; ")));
    info_.has_image = false;
    info_.has_landmarks = true;
    info_.has_odometry = !log.velocities.empty();
    info_.frame_count = static_cast<std::int64_t>(frames_.size());
    info_.warnings.insert(info_.warnings.end(), log.warnings.begin(), log.warnings.end());
    choice_ = FrameChoice(options, info_.frame_count, info_.path);
  }

  const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (position_ >= choice_.count) return std::nullopt;
    return std::move(frames_[static_cast<std::size_t>(choice_.index(position_++))]);
  }

 private:
  SourceInfo info_;
  std::vector<Frame> frames_;
  FrameChoice choice_;
  std::int64_t position_ = 0;
};

/// "Robot1" of "Robot1_Odometry.dat" and its like; empty for any other name.
std::string robot_of(const fs::path& file) {
  const std::string name = file.filename().string();
  const auto end = name.find('_');
  const std::string kind = end == std::string::npos ? "" : name.substr(end);
  const bool known = kind == "_Odometry.dat" || kind == "_Measurement.dat" || kind == "_Groundtruth.dat";
  return known && name.starts_with("Robot") ? name.substr(0, end) : "";
}

std::string first_robot(const fs::path& folder) {
  for (int robot = 1; robot <= 5; ++robot) {
    const std::string name = fmt::format("Robot{}", robot);
    if (is_file(folder / (name + "_Odometry.dat"))) return name;
  }
  return "";
}

}  // namespace

std::unique_ptr<Source> open_landmark_log(const std::string& path, const OpenOptions& options) {
  SourceInfo info;
  info.path = path;
  info.format = "landmark_log";
  const auto ground_truth = fs::path(path).replace_filename("groundtruth.txt");
  if (is_file(ground_truth))
    read_ground_truth(info, ground_truth, "body", [&] {
      return parse_tum_trajectory(read_text_file(ground_truth.string()), ground_truth.string());
    });
  return std::make_unique<LandmarkSource>(std::move(info), parse_landmark_log(read_text_file(path), path), options);
}

std::unique_ptr<Source> open_mrclam(const std::string& path, const OpenOptions& options) {
  const fs::path folder = is_folder(path) ? fs::path(path) : fs::path(path).parent_path();
  const std::string robot = is_folder(path) ? first_robot(folder) : robot_of(path);
  if (robot.empty()) return nullptr;
  SourceInfo info;
  info.path = path;
  info.format = "mrclam";
  const auto file = [&](const std::string& name) { return (folder / name).string(); };
  const auto odometry = file(robot + "_Odometry.dat"), measurement = file(robot + "_Measurement.dat"),
             barcodes = file("Barcodes.dat"), ground_truth = file(robot + "_Groundtruth.dat");
  LandmarkLog log;
  parse_mrclam_odometry(log, read_text_file(odometry), odometry);
  parse_mrclam_measurements(log, parse_mrclam_barcodes(read_text_file(barcodes), barcodes), read_text_file(measurement),
                            measurement);
  if (is_file(ground_truth))
    read_ground_truth(info, ground_truth, "body",
                      [&] { return parse_mrclam_ground_truth(read_text_file(ground_truth), ground_truth); });
  return std::make_unique<LandmarkSource>(std::move(info), log, options);
}

}  // namespace rastro
