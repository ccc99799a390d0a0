// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <string>

#include <foxglove.pb.h>

#include "rastro/base/error.h"
#include "rastro/base/time.h"
#include "rastro/math/se3.h"

namespace rastro::detail {

using MessageTime = google::protobuf::Timestamp;

inline void set_time(TimeNs time, MessageTime& message) {
  constexpr TimeNs second = 1'000'000'000;
  message.set_seconds(time / second);
  message.set_nanos(static_cast<std::int32_t>(time % second));
}

/// Of a Vector3 or Point3.
template <typename Message>
void set_vector(const Eigen::Vector3d& vector, Message& message) {
  message.set_x(vector.x());
  message.set_y(vector.y());
  message.set_z(vector.z());
}

inline void set_quaternion(const Eigen::Quaterniond& rotation, foxglove::Quaternion& message) {
  message.set_x(rotation.x());
  message.set_y(rotation.y());
  message.set_z(rotation.z());
  message.set_w(rotation.w());
}

inline void set_pose(const SE3& pose, foxglove::Pose& message) {
  set_vector(pose.translation(), *message.mutable_position());
  set_quaternion(pose.rotation().quaternion(), *message.mutable_orientation());
}

/// Red, green, blue, opacity from 0 to 1.
inline void set_color(const std::array<double, 4>& color, foxglove::Color& message) {
  message.set_r(color[0]);
  message.set_g(color[1]);
  message.set_b(color[2]);
  message.set_a(color[3]);
}

/// The same bytes for the same message: none has a map in it.
inline std::string bytes_of_message(const google::protobuf::Message& message) {
  std::string bytes;
  if (!message.SerializeToString(&bytes))
    throw Error("a message of over 2 GiB does not fit into MCAP's Protobuf", "--to mcap", "show fewer points");
  return bytes;
}

}  // namespace rastro::detail
