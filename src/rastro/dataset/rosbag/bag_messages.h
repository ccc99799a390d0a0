// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <std_msgs/Header.h>

#include <memory>
#include <new>
#include <string>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/dataset/depth_readings.h"
#include "rastro/dataset/image_file.h"
#include "rastro/dataset/rosbag/bag_records.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// The generated messages ask their allocator for rebind, which std::allocator lost in C++20; this gives it back. And
/// it gives no more than a message may need: a damaged one asks for any size.
template <typename T>
struct MessageAllocator : std::allocator<T> {
  MessageAllocator() = default;
  template <typename Other>
  MessageAllocator(const MessageAllocator<Other>&) {}
  T* allocate(std::size_t count) {
    constexpr std::size_t most_bytes = std::size_t{1} << 28;
    if (count > most_bytes / sizeof(T)) throw std::bad_alloc();
    return std::allocator<T>::allocate(count);
  }
  template <typename Other>
  struct rebind {                           // NOLINT(readability-identifier-naming): the standard's names.
    using other = MessageAllocator<Other>;  // NOLINT(readability-identifier-naming)
  };
};
using ScanMessage = sensor_msgs::LaserScan_<MessageAllocator<void>>;
using ImageMessage = sensor_msgs::Image_<MessageAllocator<void>>;
using CompressedMessage = sensor_msgs::CompressedImage_<MessageAllocator<void>>;
using CameraMessage = sensor_msgs::CameraInfo_<MessageAllocator<void>>;
using ImuMessage = sensor_msgs::Imu_<MessageAllocator<void>>;
using OdometryMessage = nav_msgs::Odometry_<MessageAllocator<void>>;
using HeaderMessage = std_msgs::Header_<MessageAllocator<void>>;

/// Error, naming `where`, for a message that is damaged or of another version of its type.
template <typename Message>
Message decode(const BagMessage& message, const std::string& where) {
  if (message.md5 != ros::message_traits::MD5Sum<Message>::value())
    throw Error("the message is of another version of " + message.type, where, "");
  Message decoded;
  try {
    ros::serialization::IStream stream(const_cast<std::uint8_t*>(message.bytes.data()),
                                       static_cast<std::uint32_t>(message.bytes.size()));
    ros::serialization::deserialize(stream, decoded);
  } catch (const std::exception& exception) {
    throw Error("the message is damaged (" + one_line(exception.what()) + ")", where, "");
  }
  return decoded;
}

/// Nanoseconds of a ROS time.
TimeNs nanoseconds(const ros::Time& time);
/// The stamp of the header that a message begins with; when it was recorded where the header has none.
TimeNs stamp_of(const BagMessage& message);

// Each throws Error, naming `where`, for a message that is not sound.
LaserScan scan_of(const ScanMessage& message, const std::string& where);
SE2 pose_of(const OdometryMessage& message, const std::string& where);
ImuSample sample_of(const ImuMessage& message);
DecodedImage image_of(const ImageMessage& message, bool want_color, const std::string& where);
DecodedImage image_of(const CompressedMessage& message, bool want_color, const std::string& where);
/// Meters from an Image of 16UC1 (millimeters) or 32FC1 (meters), or from a CompressedImage of compressedDepth.
DepthImage depth_of(const BagMessage& message, const std::string& where, const DepthReadings& readings);
bool is_depth(const ImageMessage& message);
/// Whether image_transport's compressedDepth packed it, in any way; and whether as PNG, which is read.
bool is_packed_depth(const CompressedMessage& message);
bool is_depth(const CompressedMessage& message);
/// nullopt where the message says that nobody calibrated. Error where it has a distortion that Camera does not have.
std::optional<Camera> camera_of(const CameraMessage& message, bool rectified, const std::string& where);

}  // namespace rastro
