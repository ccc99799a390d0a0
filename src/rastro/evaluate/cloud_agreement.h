// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "rastro/base/task_pool.h"
#include "rastro/map/cloud/point_cloud.h"
#include "rastro/map/mesh/triangle_mesh.h"

namespace rastro {

/// Settings of the comparison of a cloud with the true surfaces: with triangles if there are any, else with the
/// vertices as points.
struct CloudAgreementOptions {
  double tolerance_m = 0.02;  ///< Closer counts as a match.
  double spacing_m = 0.01;    ///< Spacing of the samples on the true triangles for completeness.
};

/// Distances in meters. nan without data.
struct CloudAgreement {
  std::size_t points = 0;                                                          ///< Number of points of the cloud.
  double mean = 0.0, median = 0.0, rms = 0.0, percentile_95 = 0.0, largest = 0.0;  ///< From points to the ground truth.
  double precision = 0.0;  ///< Share of points within the tolerance of the ground truth.
  /// Share of the ground truth within the tolerance of a point; unobserved parts count too.
  double completeness = 0.0;
  double sigma_ratio = 0.0;  ///< Root mean square of distance / sigma, over points with a sigma; 1 is consistent.
};

/// Both in one frame. Positions are compared by nearest neighbors (Muja and Lowe's k-d trees as in nanoflann). The
/// same for any pool. Throws Error if either is empty.
CloudAgreement cloud_agreement(const TriangleMesh& ground_truth, const PointCloud& cloud,
                               const CloudAgreementOptions& options, TaskPool* pool = nullptr);

}  // namespace rastro
