// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include "rastro/camera/camera.h"
#include "rastro/map/file/bytes.h"
#include "rastro/math/se3.h"

namespace rastro {

/// Changes a rotation by a few units in the last place at most, to one that reads back to the last bit.
void put(ByteWriter& bytes, const SO3& rotation);
SO3 get_rotation(ByteReader& bytes);
void put(ByteWriter& bytes, const Eigen::Vector3d& vector);
Eigen::Vector3d get_vector(ByteReader& bytes);
void put(ByteWriter& bytes, const SE3& pose);
SE3 get_pose(ByteReader& bytes);
void put(ByteWriter& bytes, const Camera& camera);
Camera get_camera(ByteReader& bytes);

}  // namespace rastro
