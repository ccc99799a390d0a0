// SPDX-License-Identifier: Apache-2.0
#if RASTRO_WITH_ROSBAG

#include "rastro/dataset/rosbag/bag_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/base/error.h"
#include "rastro/base/library_output.h"
#include "rastro/base/text.h"
#include "rastro/dataset/mat_conversion.h"
#include "rastro/image/image_header.h"

namespace rastro {
namespace {

/// How the pixels of one ROS encoding lie in memory, and how OpenCV converts them to BGR.
struct Encoding {
  std::string_view name;
  int type;
  int to_bgr;  ///< cv::ColorConversionCodes, or -1.
};

// ROS names the Bayer pattern by its first row, OpenCV by its second.
constexpr std::array<Encoding, 14> encodings = {{{"mono8", CV_8UC1, -1},
                                                 {"8UC1", CV_8UC1, -1},
                                                 {"mono16", CV_16UC1, -1},
                                                 {"16UC1", CV_16UC1, -1},
                                                 {"32FC1", CV_32FC1, -1},
                                                 {"bgr8", CV_8UC3, -1},
                                                 {"8UC3", CV_8UC3, -1},
                                                 {"bgra8", CV_8UC4, -1},
                                                 {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
                                                 {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
                                                 {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2BGR},
                                                 {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2BGR},
                                                 {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2BGR},
                                                 {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2BGR}}};

/// A view of the message's own bytes, converted to BGR where it has colors in another order.
cv::Mat mat_of(const ImageMessage& message, const std::string& where) {
  const auto encoding = std::find_if(encodings.begin(), encodings.end(),
                                     [&](const Encoding& known) { return known.name == message.encoding; });
  if (encoding == encodings.end())
    throw Error("the image's encoding " + in_quotes(message.encoding) + " is not known", where, "");
  constexpr std::uint32_t most_pixels = 1U << 15;  // A side.
  const std::uint64_t row = std::uint64_t{message.width} * static_cast<std::uint64_t>(CV_ELEM_SIZE(encoding->type));
  if (message.width == 0 || message.height == 0 || message.width > most_pixels || message.height > most_pixels ||
      message.step < row || message.step % CV_ELEM_SIZE1(encoding->type) != 0 ||
      message.data.size() < std::uint64_t{message.step} * message.height) {
    throw Error(fmt::format("the image should be {}x{} with {} bytes per row, but has {} bytes", message.width,
                            message.height, message.step, message.data.size()),
                where, "");
  }
  if (message.is_bigendian != 0 && CV_MAT_DEPTH(encoding->type) != CV_8U)
    throw Error("the image has its bytes in the order of big-endian machines", where, "");
  const cv::Mat mat(static_cast<int>(message.height), static_cast<int>(message.width), encoding->type,
                    const_cast<std::uint8_t*>(message.data.data()), message.step);
  if (encoding->to_bgr < 0) return mat;
  cv::Mat bgr;
  cv::cvtColor(mat, bgr, encoding->to_bgr);
  return bgr;
}

DecodedImage decoded(const cv::Mat& mat, bool want_color, const std::string& where) {
  DecodedImage image;
  const auto reason = convert(mat, want_color, image);
  if (!reason.empty()) throw Error("the image " + reason, where, "");
  return image;
}

void require_finite(bool finite, const char* what, const std::string& where) {
  if (!finite) throw Error(fmt::format("{} is not finite", what), where, "");
}

}  // namespace

TimeNs nanoseconds(const ros::Time& time) {
  return static_cast<TimeNs>(time.sec) * ns_per_second + static_cast<TimeNs>(time.nsec);
}

LaserScan scan_of(const ScanMessage& message, const std::string& where) {
  LaserScan scan;
  scan.first_angle = static_cast<double>(message.angle_min);
  scan.angle_step = static_cast<double>(message.angle_increment);
  scan.min_range = static_cast<double>(message.range_min);
  scan.max_range = static_cast<double>(message.range_max);
  require_finite(std::isfinite(scan.first_angle) && std::isfinite(scan.angle_step) && std::isfinite(scan.min_range) &&
                     std::isfinite(scan.max_range),
                 "the scan's geometry", where);
  scan.ranges.assign(message.ranges.begin(), message.ranges.end());
  return scan;
}

SE2 pose_of(const OdometryMessage& message, const std::string& where) {
  const auto& position = message.pose.pose.position;
  const auto& orientation = message.pose.pose.orientation;
  const double angle = std::atan2(2.0 * (orientation.w * orientation.z + orientation.x * orientation.y),
                                  1.0 - 2.0 * (orientation.y * orientation.y + orientation.z * orientation.z));
  require_finite(std::abs(position.x) < 1e9 && std::abs(position.y) < 1e9 && std::isfinite(angle), "the odometry",
                 where);
  return {SO2::from_angle(angle), {position.x, position.y}};
}

ImuSample sample_of(const ImuMessage& message) {
  const auto& rate = message.angular_velocity;
  const auto& acceleration = message.linear_acceleration;
  return {
      nanoseconds(message.header.stamp), {rate.x, rate.y, rate.z}, {acceleration.x, acceleration.y, acceleration.z}};
}

DecodedImage image_of(const ImageMessage& message, bool want_color, const std::string& where) {
  return decoded(mat_of(message, where), want_color, where);
}

DecodedImage image_of(const CompressedMessage& message, bool want_color, const std::string& where) {
  const auto incomplete = why_incomplete(message.data);
  if (!incomplete.empty()) throw Error("the image " + incomplete, where, "");
  if (const auto reason = why_too_large(message.data); !reason.empty())
    throw Error("the image " + reason, where, "scale the images down");
  cv::Mat mat;
  const LibraryOutput output;
  try {
    const cv::Mat bytes(1, static_cast<int>(message.data.size()), CV_8UC1,
                        const_cast<std::uint8_t*>(message.data.data()));
    if (!message.data.empty()) mat = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    mat.release();
  }
  if (mat.empty()) throw Error("the image cannot be decoded", where, "");
  return decoded(mat, want_color, where);
}

bool is_depth(const ImageMessage& message) { return message.encoding == "16UC1" || message.encoding == "32FC1"; }

DepthImage depth_of(const ImageMessage& message, const std::string& where, const DepthReadings& readings) {
  const cv::Mat mat = mat_of(message, where);
  DepthImage depth(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) {
    for (int x = 0; x < mat.cols; ++x) {
      const float meters =
          mat.depth() == CV_32F ? mat.at<float>(y, x) : static_cast<float>(mat.at<std::uint16_t>(y, x)) * 1e-3F;
      depth.at(x, y) = std::isfinite(meters) && meters > 0.0F && meters < 65.0F ? readings.corrected(meters) : 0.0F;
    }
  }
  return depth;
}

std::optional<Camera> camera_of(const CameraMessage& message, bool rectified) {
  Camera camera;
  camera.width = static_cast<int>(std::min(message.width, 1U << 15));
  camera.height = static_cast<int>(std::min(message.height, 1U << 15));
  camera.fx = rectified ? message.P[0] : message.K[0];
  camera.cx = rectified ? message.P[2] : message.K[2];
  camera.fy = rectified ? message.P[5] : message.K[4];
  camera.cy = rectified ? message.P[6] : message.K[5];
  if (!(camera.fx > 0.0) || !(camera.fy > 0.0) || !std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy))
    return std::nullopt;
  const auto& coefficients = message.D;
  const bool none = std::all_of(coefficients.begin(), coefficients.end(), [](double value) { return value == 0.0; });
  if (rectified || none) return camera;
  const bool brown = message.distortion_model == "plumb_bob" && coefficients.size() <= 5;
  const bool equidistant =
      (message.distortion_model == "equidistant" || message.distortion_model == "fisheye") && coefficients.size() == 4;
  const bool rational = message.distortion_model == "rational_polynomial" && coefficients.size() == 8;
  if (!brown && !equidistant && !rational) return std::nullopt;
  if (!std::all_of(coefficients.begin(), coefficients.end(), [](double value) { return std::isfinite(value); }))
    return std::nullopt;
  camera.distortion = brown ? Distortion::radial_tangential : rational ? Distortion::rational : Distortion::equidistant;
  std::copy(coefficients.begin(), coefficients.end(), camera.coefficients.begin());
  return camera;
}

}  // namespace rastro

#endif
