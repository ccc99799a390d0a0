// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "rastro/base/task_pool.h"
#include "rastro/map/cloud/point_cloud.h"
#include "rastro/map/mesh/triangle_mesh.h"

namespace rastro {

/// What a cloud is compared with: surfaces where there are triangles, else the vertices as points.
struct CloudAgreementOptions {
  double tolerance_m = 0.02;  ///< Nearer counts as the same place.
  double spacing_m = 0.01;    ///< Of the places on the truth's triangles that should be covered.
};

/// Distances in metres. nan where there is nothing to say.
struct CloudAgreement {
  std::size_t points = 0;                                                          ///< Of the cloud.
  double mean = 0.0, median = 0.0, rms = 0.0, percentile_95 = 0.0, largest = 0.0;  ///< From points to the truth.
  double precision = 0.0;     ///< Share of points within the tolerance of the truth.
  double completeness = 0.0;  ///< Share of the truth within the tolerance of a point; what was never seen counts too.
  double sigma_ratio = 0.0;   ///< Root mean square of distance / sigma, over points with a sigma; 1 is honest.
};

/// Both in one frame. Places are compared by nearest neighbours (Muja and Lowe's k-d trees as nanoflann has them). The
/// same for any pool. Error where either is empty.
CloudAgreement cloud_agreement(const TriangleMesh& truth, const PointCloud& cloud, const CloudAgreementOptions& options,
                               TaskPool* pool = nullptr);

}  // namespace rastro
