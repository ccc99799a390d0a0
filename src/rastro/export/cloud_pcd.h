// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/export/ply.h"
#include "rastro/map/cloud/point_cloud.h"

namespace rastro {

/// Binary PCD v0.7 as the Point Cloud Library reads it: x y z normal_x normal_y normal_z rgb count sigma (nan: not
/// known).
std::string cloud_pcd(const PointCloud& cloud, const std::string& frame, const CloudTerms& terms = {});

}  // namespace rastro
