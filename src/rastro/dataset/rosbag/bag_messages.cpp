// SPDX-License-Identifier: Apache-2.0
#if RASTRO_WITH_ROSBAG

#include "rastro/dataset/rosbag/bag_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/base/error.h"
#include "rastro/base/library_output.h"
#include "rastro/base/text.h"
#include "rastro/camera/file/formats.h"
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

/// The pixels of a whole PNG or JPEG file, as they are.
cv::Mat unpacked(std::span<const std::uint8_t> file, const std::string& where) {
  const auto incomplete = why_incomplete(file);
  if (!incomplete.empty()) throw Error("the image " + incomplete, where, "");
  if (const auto reason = why_too_large(file); !reason.empty())
    throw Error("the image " + reason, where, "scale the images down");
  cv::Mat mat;
  const LibraryOutput output;
  try {
    const cv::Mat bytes(1, static_cast<int>(file.size()), CV_8UC1, const_cast<std::uint8_t*>(file.data()));
    if (!file.empty()) mat = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    mat.release();
  }
  if (mat.empty()) throw Error("the image cannot be decoded", where, "");
  return mat;
}

/// Meters by pixel, without those that are no measurement, corrected.
template <typename MetersAt>
DepthImage depth_image(const cv::Mat& mat, const DepthReadings& readings, MetersAt meters_at) {
  DepthImage depth(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) {
    for (int x = 0; x < mat.cols; ++x) {
      const float meters = meters_at(x, y);
      depth.at(x, y) = std::isfinite(meters) && meters > 0.0F && meters < 65.0F ? readings.corrected(meters) : 0.0F;
    }
  }
  return depth;
}

DepthImage plain_depth(const ImageMessage& message, const std::string& where, const DepthReadings& readings) {
  const cv::Mat mat = mat_of(message, where);
  if (mat.depth() == CV_32F) return depth_image(mat, readings, [&](int x, int y) { return mat.at<float>(y, x); });
  return depth_image(mat, readings,
                     [&](int x, int y) { return static_cast<float>(mat.at<std::uint16_t>(y, x)) * 1e-3F; });
}

/// compressed_depth_image_transport's ConfigHeader: the kind of packing, and A and B of inverse depth.
constexpr std::size_t packed_header_size = 12;

std::span<const std::uint8_t> packed_file(const CompressedMessage& message) {
  const std::span<const std::uint8_t> bytes(message.data.data(), message.data.size());
  return bytes.subspan(std::min(packed_header_size, bytes.size()));
}

/// Depth in meters (32FC1) is packed as A / depth + B, so that what is near keeps more digits.
DepthImage packed_depth(const CompressedMessage& message, const std::string& where, const DepthReadings& readings) {
  const cv::Mat mat = unpacked(packed_file(message), where);
  if (mat.type() != CV_16UC1) throw Error("the depth image is not one channel of 16 bit", where, "");
  const auto raw = [&](int x, int y) { return static_cast<float>(mat.at<std::uint16_t>(y, x)); };
  if (!message.format.starts_with("32FC1"))
    return depth_image(mat, readings, [&](int x, int y) { return raw(x, y) * 1e-3F; });
  float a = 0.0F, b = 0.0F;
  std::memcpy(&a, message.data.data() + 4, sizeof(a));
  std::memcpy(&b, message.data.data() + 8, sizeof(b));
  return depth_image(mat, readings, [&](int x, int y) { return raw(x, y) > 0.0F ? a / (raw(x, y) - b) : 0.0F; });
}

/// At least as many coefficients as the model has; drivers leave out zeros at the end.
std::vector<double> coefficients_of(const CameraMessage& message, bool equidistant) {
  std::vector<double> coefficients(message.D.begin(), message.D.end());
  coefficients.resize(std::max<std::size_t>(coefficients.size(), equidistant ? 4 : 5), 0.0);
  return coefficients;
}

}  // namespace

TimeNs nanoseconds(const ros::Time& time) {
  return static_cast<TimeNs>(time.sec) * ns_per_second + static_cast<TimeNs>(time.nsec);
}

TimeNs stamp_of(const BagMessage& message) {
  HeaderMessage header;
  try {
    ros::serialization::IStream stream(const_cast<std::uint8_t*>(message.bytes.data()),
                                       static_cast<std::uint32_t>(message.bytes.size()));
    ros::serialization::deserialize(stream, header);
  } catch (const std::exception&) {
    return message.time;  // What is damaged is said by whoever decodes the whole message.
  }
  return header.stamp.isZero() ? message.time : nanoseconds(header.stamp);
}

LaserScan scan_of(const ScanMessage& message, const std::string& where) {
  LaserScan scan;
  scan.first_angle = static_cast<double>(message.angle_min);
  scan.angle_step = static_cast<double>(message.angle_increment);
  scan.min_range = static_cast<double>(message.range_min);
  scan.max_range = static_cast<double>(message.range_max);
  // Drivers that know no limit write infinity or zero; no laser of a robot sees farther than this.
  constexpr double unlimited_range = 100.0;
  if (!std::isfinite(scan.max_range) || scan.max_range <= 0.0) scan.max_range = unlimited_range;
  require_finite(std::isfinite(scan.first_angle) && std::isfinite(scan.angle_step) && std::isfinite(scan.min_range),
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
  return decoded(unpacked({message.data.data(), message.data.size()}, where), want_color, where);
}

bool is_depth(const ImageMessage& message) { return message.encoding == "16UC1" || message.encoding == "32FC1"; }

bool is_packed_depth(const CompressedMessage& message) {
  return message.format.find("compressedDepth") != CompressedMessage::_format_type::npos;
}

bool is_depth(const CompressedMessage& message) {
  constexpr std::array<std::uint8_t, 4> png = {0x89, 'P', 'N', 'G'};
  const auto file = packed_file(message);
  return is_packed_depth(message) && file.size() > png.size() && std::equal(png.begin(), png.end(), file.begin());
}

DepthImage depth_of(const BagMessage& message, const std::string& where, const DepthReadings& readings) {
  if (message.type == "sensor_msgs/CompressedImage")
    return packed_depth(decode<CompressedMessage>(message, where), where, readings);
  return plain_depth(decode<ImageMessage>(message, where), where, readings);
}

std::optional<Camera> camera_of(const CameraMessage& message, bool rectified, const std::string& where) {
  Camera camera;
  camera.width = static_cast<int>(std::min(message.width, 1U << 15));
  camera.height = static_cast<int>(std::min(message.height, 1U << 15));
  camera.fx = rectified ? message.P[0] : message.K[0];
  camera.cx = rectified ? message.P[2] : message.K[2];
  camera.fy = rectified ? message.P[5] : message.K[4];
  camera.cy = rectified ? message.P[6] : message.K[5];
  if (!(camera.fx > 0.0) || !(camera.fy > 0.0) || !std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy))
    return std::nullopt;
  const std::string model(message.distortion_model.begin(), message.distortion_model.end());
  const bool equidistant = model == "equidistant" || model == "fisheye";
  const auto coefficients = coefficients_of(message, equidistant);
  const bool none = std::all_of(coefficients.begin(), coefficients.end(), [](double value) { return value == 0.0; });
  // An equidistant lens bends rays with zeros too; of any other model, known or not, they mean no distortion.
  if (rectified || (none && !equidistant)) return camera;
  calibration::set_distortion(camera, model, coefficients, where, "D");
  return camera;
}

}  // namespace rastro

#endif
