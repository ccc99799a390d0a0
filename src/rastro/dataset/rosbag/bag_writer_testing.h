// SPDX-License-Identifier: Apache-2.0
// For tests: bags written by ROS itself.
#pragma once

#include <rosbag/bag.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "rastro/dataset/rosbag/bag_messages.h"

namespace rastro {

/// Times of the headers; the recorder is 5 ms late unless told otherwise.
inline ros::Time at(double seconds) { return ros::Time(1000.0 + seconds); }

/// Writes a bag for a test. Messages are written in the order of the calls.
class BagWriter {
 public:
  double late_s = 0.005;   ///< Time of recording less that of the header.
  bool has_stamps = true;  ///< Headers are 0 otherwise.

  explicit BagWriter(const std::string& path,
                     rosbag::compression::CompressionType packed = rosbag::compression::Uncompressed) {
    bag_.open(path, rosbag::bagmode::Write);
    bag_.setCompression(packed);
    bag_.setChunkThreshold(2000);
  }

  template <typename Message>
  void write(const std::string& topic, double seconds, Message message) {
    message.header.stamp = has_stamps ? at(seconds) : ros::Time();
    bag_.write(topic, at(seconds + late_s), message);
  }

  void scan(const std::string& topic, double seconds, float most_range = 10.0F) {
    ScanMessage message;
    message.angle_min = -1.0F;
    message.angle_increment = 0.5F;
    message.range_min = 0.1F;
    message.range_max = most_range;
    message.ranges = {1.0F, std::numeric_limits<float>::infinity(), std::nanf(""), static_cast<float>(seconds) + 2.0F};
    write(topic, seconds, message);
  }

  void odometry(double seconds, double x, double angle) {
    OdometryMessage message;
    message.pose.pose.position.x = x;
    message.pose.pose.orientation.z = std::sin(angle / 2.0);
    message.pose.pose.orientation.w = std::cos(angle / 2.0);
    write("/odom", seconds, message);
  }

  void imu(double seconds, double yaw_rate) {
    ImuMessage message;
    message.angular_velocity.z = yaw_rate;
    message.linear_acceleration.z = 9.81;
    write("/imu", seconds, message);
  }

  void image(const std::string& topic, double seconds, const std::string& encoding, std::vector<std::uint8_t> pixel,
             int width = 8, int height = 6) {
    ImageMessage message;
    message.width = static_cast<std::uint32_t>(width);
    message.height = static_cast<std::uint32_t>(height);
    message.step = static_cast<std::uint32_t>(width) * static_cast<std::uint32_t>(pixel.size()) + 4U;
    message.encoding = encoding.c_str();
    message.data.resize(std::size_t{message.step} * message.height);
    for (std::uint32_t y = 0; y < message.height; ++y)
      for (std::uint32_t k = 0; k < message.step - 4U; ++k)
        message.data[y * message.step + k] = pixel[k % pixel.size()];
    write(topic, seconds, message);
  }

  void packed(const std::string& topic, double seconds, const std::string& format, std::vector<std::uint8_t> bytes) {
    CompressedMessage message;
    message.format = format.c_str();
    message.data.assign(bytes.begin(), bytes.end());
    write(topic, seconds, message);
  }

  void camera_info(const std::string& topic, double seconds, const std::string& model = "plumb_bob",
                   const std::vector<double>& coefficients = {0.01, -0.02, 0.001, 0.002, 0.003}, int width = 8) {
    CameraMessage message;
    message.width = static_cast<std::uint32_t>(width);
    message.height = 6;
    message.distortion_model = model.c_str();
    message.D.assign(coefficients.begin(), coefficients.end());
    message.K = {{9.0, 0.0, 4.0, 0.0, 9.5, 3.0, 0.0, 0.0, 1.0}};
    write(topic, seconds, message);
  }

 private:
  rosbag::Bag bag_;
};

}  // namespace rastro
