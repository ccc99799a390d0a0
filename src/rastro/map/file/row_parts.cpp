// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/row_parts.h"

#include <cmath>

namespace rastro {
namespace {

using Eigen::Quaterniond;

bool same(const Quaterniond& a, const Quaterniond& b) { return a.coeffs() == b.coeffs(); }

/// The nearest quaternion that SO3's normalization leaves unchanged to the last bit: a map read and written again must
/// have the same bytes.
Quaterniond unmoved_by_normalizing(const Quaterniond& quaternion) {
  int largest = 0;
  quaternion.coeffs().cwiseAbs().maxCoeff(&largest);
  for (int tries = 0; tries < 64; ++tries) {
    Quaterniond nudged = quaternion;
    double& value = nudged.coeffs()[largest];
    for (int step = 0; step < (tries + 1) / 2; ++step) value = std::nextafter(value, tries % 2 == 0 ? 2.0 : -2.0);
    if (same(SO3(nudged).quaternion(), nudged)) return nudged;
  }
  return quaternion;
}

}  // namespace

void put(ByteWriter& bytes, const SO3& rotation) {
  const Quaterniond q = unmoved_by_normalizing(rotation.quaternion());
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) bytes.put(value);
}

SO3 get_rotation(ByteReader& bytes) {
  std::array<double, 4> v{};
  for (double& value : v) value = bytes.get<double>();
  const Quaterniond q(v[0], v[1], v[2], v[3]);
  bytes.check(std::abs(q.squaredNorm() - 1.0) < 1e-9);
  return SO3(q);
}

void put(ByteWriter& bytes, const Eigen::Vector3d& vector) {
  for (int i = 0; i < 3; ++i) bytes.put(vector[i]);
}

Eigen::Vector3d get_vector(ByteReader& bytes) {
  Eigen::Vector3d vector;
  for (double& value : vector) value = bytes.get<double>();
  return vector;
}

void put(ByteWriter& bytes, const SE3& pose) {
  put(bytes, pose.rotation());
  put(bytes, pose.translation());
}

SE3 get_pose(ByteReader& bytes) {
  const SO3 rotation = get_rotation(bytes);
  return {rotation, get_vector(bytes)};
}

/// Maps of before the rational model have five.
std::size_t stored_coefficients(Distortion distortion) { return distortion == Distortion::rational ? 8 : 5; }

void put(ByteWriter& bytes, const Camera& camera) {
  bytes.put<std::int32_t>(camera.width);
  bytes.put<std::int32_t>(camera.height);
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) bytes.put(value);
  bytes.put(static_cast<std::uint8_t>(camera.distortion));
  for (std::size_t k = 0; k < stored_coefficients(camera.distortion); ++k) bytes.put(camera.coefficients[k]);
}

Camera get_camera(ByteReader& bytes) {
  constexpr int largest_side = 65'536;
  Camera camera;
  camera.width = bytes.get<std::int32_t>();
  camera.height = bytes.get<std::int32_t>();
  bytes.check(camera.width >= 0 && camera.width <= largest_side && camera.height >= 0 && camera.height <= largest_side);
  for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *value = bytes.get<double>();
  bytes.check(camera.fx > 0.0 && camera.fy > 0.0);
  const auto distortion = bytes.get<std::uint8_t>();
  bytes.check(distortion <= static_cast<std::uint8_t>(Distortion::rational));
  camera.distortion = static_cast<Distortion>(distortion);
  for (std::size_t k = 0; k < stored_coefficients(camera.distortion); ++k) camera.coefficients[k] = bytes.get<double>();
  return camera;
}

}  // namespace rastro
