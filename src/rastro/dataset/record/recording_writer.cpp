// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/record/recording_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/dataset/record/calibration_text.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr double usual_units_per_meter = 5000.0;
constexpr const char* list_header = "# stamp file\n";

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Error("the folder cannot be made (" + error.message() + ")", folder.string(), "choose another");
}

void write_png(const fs::path& file, const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  // Without a level OpenCV uses the fastest one with row differences.
  if (!cv::imencode(".png", image, bytes)) throw Error("cannot be encoded as PNG", file.string(), "");
  try {
    AppendFile(file).append({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  } catch (const Error&) {
    std::error_code ignored;
    fs::remove(file, ignored);
    throw;
  }
}

cv::Mat mat_of(const GrayImage& gray) {
  return {gray.height(), gray.width(), CV_8U, const_cast<std::uint8_t*>(gray.row(0)),
          static_cast<std::size_t>(gray.stride())};
}

/// OpenCV's order is blue first.
cv::Mat mat_of(const ColorImage& color) {
  cv::Mat mat(color.height(), color.width(), CV_8UC3);
  for (int y = 0; y < color.height(); ++y) {
    const std::uint8_t* from = color.rgb.row(y);
    std::uint8_t* to = mat.ptr<std::uint8_t>(y);
    for (int x = 0; x < 3 * color.width(); x += 3) to[x] = from[x + 2], to[x + 1] = from[x + 1], to[x + 2] = from[x];
  }
  return mat;
}

/// Of meters = raw / units_per_meter + offset_m.
cv::Mat mat_of(const DepthImage& depth, double units_per_meter, double offset_m) {
  cv::Mat mat(depth.height(), depth.width(), CV_16U);
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      const auto meters = static_cast<double>(depth.at(x, y));
      const double raw = meters > 0.0 ? std::round((meters - offset_m) * units_per_meter) : 0.0;
      mat.at<std::uint16_t>(y, x) = raw >= 1.0 && raw <= 65534.0 ? static_cast<std::uint16_t>(raw) : std::uint16_t{0};
    }
  return mat;
}

/// A color image of equal channels was gray in the source.
bool has_colors(const ColorImage& color) {
  for (int y = 0; y < color.height(); ++y) {
    const std::uint8_t* row = color.rgb.row(y);
    for (int x = 0; x < 3 * color.width(); x += 3)
      if (row[x] != row[x + 1] || row[x] != row[x + 2]) return true;
  }
  return false;
}

cv::Mat best_image(const Frame& frame) {
  return !frame.color.empty() && has_colors(frame.color) ? mat_of(frame.color) : mat_of(frame.image);
}

/// Names of files after stamps; a stamp that came before gets a number.
class StampNames {
 public:
  explicit StampNames(fs::path folder) : folder_(std::move(folder)) {}

  std::string name(const std::string& stamp) {
    // Where all stamps are the same, not every number is tried.
    repeated_ = stamp == last_ ? repeated_ + 1 : 0;
    last_ = stamp;
    std::error_code ignored;
    while (fs::exists(folder_ / numbered(), ignored)) ++repeated_;
    return numbered();
  }

 private:
  std::string numbered() const { return repeated_ == 0 ? last_ + ".png" : fmt::format("{}_{}.png", last_, repeated_); }

  const fs::path folder_;
  std::string last_;
  int repeated_ = 0;
};

}  // namespace

class RecordingWriter::Layout {
 public:
  virtual ~Layout() = default;
  virtual void write(const Frame& frame) = 0;
};

class RecordingWriter::EurocLayout final : public Layout {
 public:
  EurocLayout(const SourceInfo& info, const fs::path& folder)
      : info_(info), folder_(folder / "mav0"), left_(add_camera("cam0", 0)) {}

  void write(const Frame& frame) override {
    const std::string name = names_.name(fmt::format("{}", frame.stamp));
    const std::string line = fmt::format("{},{}\n", frame.stamp, name);
    write_png(folder_ / "cam0/data" / name, best_image(frame));
    if (!frame.right.empty()) {
      if (!right_) right_ = add_camera("cam1", 1);
      write_png(folder_ / "cam1/data" / name, mat_of(frame.right));
      right_->append(line);
    }
    left_->append(line);
  }

 private:
  std::unique_ptr<AppendFile> add_camera(const std::string& name, std::size_t index) {
    make_folder(folder_ / name / "data");
    if (index < info_.cameras.size() && info_.cameras[index].camera)
      write_whole_file(folder_ / name / "sensor.yaml",
                       euroc_calibration_text(info_.cameras[index], body_from_camera(index)));
    auto list = std::make_unique<AppendFile>(folder_ / name / "data.csv");
    list->append("#timestamp [ns],filename\n");
    return list;
  }

  /// Where the source knows no body, the left camera is it.
  SE3 body_from_camera(std::size_t index) const {
    const SE3 body_from_left = info_.cameras.front().body_from_camera.value_or(SE3());
    return index == 0 ? body_from_left : body_from_left * info_.left_from_right.value_or(SE3());
  }

  const SourceInfo info_;
  const fs::path folder_;
  StampNames names_{folder_ / "cam0/data"};
  std::unique_ptr<AppendFile> left_, right_;
};

class RecordingWriter::TumLayout final : public Layout {
 public:
  TumLayout(const SourceInfo& info, const fs::path& folder)
      : folder_(folder),
        units_per_meter_(info.depth_factor > 0.0 ? info.depth_factor : usual_units_per_meter),
        offset_m_(info.depth_offset_m) {
    make_folder(folder_ / "rgb");
    make_folder(folder_ / "depth");
    if (!info.cameras.empty() && info.cameras.front().camera)
      write_whole_file(folder_ / "camera.yaml", opencv_calibration_text(info.cameras.front()));
    std::string text = fmt::format("depth_factor: {:.17g}\n", units_per_meter_);
    if (offset_m_ != 0.0) text += fmt::format("depth_offset_m: {:.17g}\n", offset_m_);
    write_whole_file(folder_ / "info.txt", text);
    color_.append(list_header);
  }

  void write(const Frame& frame) override {
    const std::string stamp = seconds_text(frame.stamp), name = "rgb/" + names_.name(stamp);
    write_png(folder_ / name, best_image(frame));
    if (!frame.depth.empty()) {
      const std::string depth_stamp = seconds_text(frame.depth_stamp);
      const std::string depth_name = "depth/" + depth_names_.name(depth_stamp);
      write_png(folder_ / depth_name, mat_of(frame.depth, units_per_meter_, offset_m_));
      if (!depth_) {
        depth_ = std::make_unique<AppendFile>(folder_ / "depth.txt");
        depth_->append(list_header);
        // Which belongs to which, even where the nearest stamp is another's.
        pairs_ = std::make_unique<AppendFile>(folder_ / "associations.txt");
      }
      depth_->append(fmt::format("{} {}\n", depth_stamp, depth_name));
      pairs_->append(fmt::format("{} {} {} {}\n", stamp, name, depth_stamp, depth_name));
    }
    color_.append(fmt::format("{} {}\n", stamp, name));
  }

 private:
  const fs::path folder_;
  const double units_per_meter_, offset_m_;
  AppendFile color_{folder_ / "rgb.txt"};
  std::unique_ptr<AppendFile> depth_, pairs_;  ///< From the first depth on: readers refuse empty lists.
  StampNames names_{folder_ / "rgb"}, depth_names_{folder_ / "depth"};
};

RecordingWriter::RecordingWriter(const SourceInfo& info, const fs::path& folder) {
  if (!info.has_image) throw Error("has no images to record", info.path, "a laser log is a recording already");
  std::error_code ignored;
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored))
    throw Error("is not a folder", folder.string(), "choose another");
  make_folder(folder);
  lock_.emplace(folder);
  if (!fs::is_empty(folder, ignored)) throw Error("the folder is not empty", folder.string(), "choose another");
  if (info.has_depth) {
    layout_ = std::make_unique<TumLayout>(info, folder);
  } else {
    layout_ = std::make_unique<EurocLayout>(info, folder);
  }
}

RecordingWriter::~RecordingWriter() = default;

void RecordingWriter::write(const Frame& frame) {
  if (frame.image.empty()) return;
  layout_->write(frame);
  ++frames_;
}

}  // namespace rastro
