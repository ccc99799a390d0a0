// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/occluder/occluded_copy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/folder_lock.h"
#include "rastro/base/log.h"
#include "rastro/synthetic/occluder/occluder.h"
#include "rastro/synthetic/recording_files.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;
constexpr int batch_frames = 16;  // drawn sequentially, then written in parallel

struct OccludedImage {
  TimeNs stamp = 0;
  GrayImage image, mask;
};

FolderLock prepare_folder(const fs::path& folder, bool overwrite) {
  make_folder(folder);
  FolderLock lock(folder);
  std::error_code problem;
  const bool holds_something = !fs::is_empty(folder, problem);
  if (holds_something && !overwrite)
    throw Error("the folder is not empty", folder.string(), "give an empty --out, or --force to replace it");
  // Removes only the files of a copy.
  if (holds_something) {
    for (const char* part : {"cam0", "occluder", "state_groundtruth_estimate0"})
      fs::remove_all(folder / "mav0" / part, problem);
  }
  make_folder(folder / "mav0" / "cam0" / "data");
  make_folder(folder / "mav0" / "occluder");
  return lock;
}

void write_png(const fs::path& file, GrayImage& image, const std::vector<int>& settings) {
  const cv::Mat view(image.height(), image.width(), CV_8UC1, image.row(0), static_cast<std::size_t>(image.stride()));
  bool written = false;
  try {
    written = cv::imwrite(file.string(), view, settings);
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written)
    throw Error("the image cannot be written", file.string(), "check whether the disk is full or write-protected");
}

std::string matrix_rows(const SE3& pose) {
  const Eigen::Matrix4d matrix = pose.matrix();
  std::string text;
  for (int i = 0; i < 16; ++i) text += fmt::format("{}{:.12g}", i == 0 ? "" : ", ", matrix(i / 4, i % 4));
  return text;
}

std::string camera_yaml(const Camera& camera, const SE3& body_from_camera, int width, int height) {
  std::string text = "# Camera of the recording that this copy was made from.\nsensor_type: camera\n";
  text += fmt::format("T_BS:\n  cols: 4\n  rows: 4\n  data: [{}]\n", matrix_rows(body_from_camera));
  text += fmt::format("resolution: [{}, {}]\ncamera_model: pinhole\n", width, height);
  text += fmt::format("intrinsics: [{:.12g}, {:.12g}, {:.12g}, {:.12g}]\n", camera.fx, camera.fy, camera.cx, camera.cy);
  text += fmt::format("distortion_model: {}\n", camera.distortion == Distortion::equidistant ? "equidistant"
                                                : camera.distortion == Distortion::rational  ? "rational_polynomial"
                                                                                             : "radial-tangential");
  const std::size_t count = std::max<std::size_t>(4, camera.coefficient_count());
  text += "distortion_coefficients: [";
  for (std::size_t i = 0; i < count; ++i) text += fmt::format("{}{:.12g}", i == 0 ? "" : ", ", camera.coefficients[i]);
  return text + "]\n";
}

void write_ground_truth(const SourceInfo& info, const fs::path& folder) {
  if (info.ground_truth.empty()) return;
  make_folder(folder);
  std::string text = "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n";
  for (const StampedPose& pose : info.ground_truth) {
    const Eigen::Vector3d& p = pose.world_from_body.translation();
    const Eigen::Quaterniond& q = pose.world_from_body.rotation().quaternion();
    text += fmt::format("{},{:.9g},{:.9g},{:.9g},{:.12g},{:.12g},{:.12g},{:.12g}\n", pose.stamp, p.x(), p.y(), p.z(),
                        q.w(), q.x(), q.y(), q.z());
  }
  write_whole_file(folder / "data.csv", text);
}

/// Calibration and ground truth. Camera poses (TUM, KITTI) are written as poses of a body that is the camera.
void write_sensors(const SourceInfo& info, const fs::path& folder, int width, int height) {
  const bool of_camera = info.ground_truth_frame == "camera";
  if (!info.cameras.empty() && info.cameras.front().camera) {
    const CalibratedCamera& camera = info.cameras.front();
    const SE3 body_from_camera = of_camera ? SE3() : camera.body_from_camera.value_or(SE3());
    write_whole_file(folder / "mav0" / "cam0" / "sensor.yaml",
                     camera_yaml(*camera.camera, body_from_camera, width, height));
  }
  write_ground_truth(info, folder / "mav0" / "state_groundtruth_estimate0");
}

OccluderOptions light_of(const GrayImage& image, std::uint64_t seed) {
  double sum = 0.0, squares = 0.0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double gray = image.at(x, y);
      sum += gray;
      squares += gray * gray;
    }
  }
  const double count = static_cast<double>(image.width()) * image.height();
  const double mean = sum / count;
  return {seed, mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

std::string occluder_yaml(const SourceInfo& info, std::uint64_t seed, Occluder& occluder, std::int64_t frames) {
  std::string text = fmt::format(
      "# Occluder drawn by `rastro occlude`; STAMP.png beside this file is its mask.\nseed: {}\nformat: {}\n", seed,
      info.format);
  text += fmt::format("frames: {}\npasses:\n", frames);
  for (std::int64_t frame = 0; frame < frames;) {
    const OccluderPass& pass = occluder.pass_at(frame);
    if (pass.first >= frames) break;
    text +=
        fmt::format("  - {{first: {}, frames: {}, shape: {}, to_right: {}, width_px: {:.1f}, hidden_frames: {:.1f}}}\n",
                    pass.first, pass.frames, pass.appearance.shape == OccluderShape::post ? "post" : "figure",
                    pass.to_right, pass.appearance.width_px, pass.occluded_frames);
    frame = pass.first + pass.frames;
  }
  return text;
}

/// The copy being written.
class Copy {
 public:
  Copy(Source& source, const fs::path& folder, const OccludedCopyOptions& options, TaskPool& pool)
      : source_(source),
        folder_(folder),
        lock_(prepare_folder(folder, options.overwrite)),
        options_(options),
        pool_(pool) {
    list_.emplace(folder / "mav0" / "cam0" / "data.csv");
    list_->append("#timestamp [ns],filename\n");
  }

  OccludedCopyResult run(const std::function<void(std::int64_t)>& progress) {
    std::vector<OccludedImage> batch;
    for (bool more = true; more;) {
      batch.clear();
      while (static_cast<int>(batch.size()) < batch_frames && (more = read_into(batch))) {
      }
      write(batch);
      if (progress && !batch.empty()) progress(result_.frames);
    }
    if (result_.frames == 0)
      throw Error("there is no readable frame", source_.info().path, "see `rastro check` on the data");
    result_.covered_share = covered_pixels_ / static_cast<double>(result_.frames);
    return result_;
  }

 private:
  /// False at the end of the source.
  bool read_into(std::vector<OccludedImage>& batch) {
    std::optional<Frame> frame;
    try {
      frame = source_.next();
    } catch (const Error& error) {
      ++result_.skipped;
      if (result_.skipped > 100) throw;
      log_warning(std::string("skipped: ") + error.what());
      return true;
    }
    if (!frame) return false;
    if (!occluder_) start(frame->image);
    const GrayImage& image = frame->image;
    if (image.width() != width_ || image.height() != height_)
      throw Error(fmt::format("the image is {}x{}, the previous ones are {}x{}", image.width(), image.height(), width_,
                              height_),
                  frame->name, "give a sequence with images of one size");
    if (drawn_ > 0 && frame->stamp <= last_stamp_)
      throw Error(fmt::format("its stamp {} ns is not after that of the previous frame", frame->stamp), frame->name,
                  "see `rastro check` on the data");
    last_stamp_ = frame->stamp;
    OccludedImage occluded{frame->stamp, std::move(frame->image), {}};
    occluder_->draw(drawn_++, occluded.image, occluded.mask);
    batch.push_back(std::move(occluded));
    return true;
  }

  void start(const GrayImage& first) {
    width_ = first.width();
    height_ = first.height();
    occluder_.emplace(width_, height_, light_of(first, options_.seed));
    write_sensors(source_.info(), folder_, width_, height_);
  }

  void write(std::vector<OccludedImage>& batch) {
    const auto count = static_cast<int>(batch.size());
    pool_.for_chunks(0, count, 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        OccludedImage& occluded = batch[static_cast<std::size_t>(i)];
        const std::string name = fmt::format("{}.png", occluded.stamp);
        write_png(folder_ / "mav0" / "cam0" / "data" / name, occluded.image, {cv::IMWRITE_PNG_COMPRESSION, 1});
        write_png(folder_ / "mav0" / "occluder" / name, occluded.mask, {cv::IMWRITE_PNG_BILEVEL, 1});
      }
    });
    for (OccludedImage& occluded : batch) {
      list_->append(fmt::format("{0},{0}.png\n", occluded.stamp));
      count_covered(occluded.mask);
      ++result_.frames;
    }
    if (occluder_)
      write_whole_file(folder_ / "mav0" / "occluder" / "occluder.yaml",
                       occluder_yaml(source_.info(), options_.seed, *occluder_, result_.frames));
  }

  void count_covered(const GrayImage& mask) {
    std::int64_t covered = 0;
    for (int y = 0; y < mask.height(); ++y) covered += std::count(mask.row(y), mask.row(y) + mask.width(), 255);
    result_.covered_frames += covered > 0;
    covered_pixels_ += static_cast<double>(covered) / (static_cast<double>(mask.width()) * mask.height());
  }

  Source& source_;
  fs::path folder_;
  FolderLock lock_;
  OccludedCopyOptions options_;
  TaskPool& pool_;
  std::optional<AppendFile> list_;
  std::optional<Occluder> occluder_;
  OccludedCopyResult result_;
  int width_ = 0, height_ = 0;
  std::int64_t drawn_ = 0;
  TimeNs last_stamp_ = 0;
  double covered_pixels_ = 0.0;
};

}  // namespace

OccludedCopyResult write_occluded_copy(Source& source, const fs::path& folder, const OccludedCopyOptions& options,
                                       TaskPool& pool, const std::function<void(std::int64_t)>& progress) {
  return Copy(source, folder, options, pool).run(progress);
}

}  // namespace rastro
