// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <ceres/ceres.h>

namespace rastro {

/// How graphs of poses are solved: sparse, silent, and on one thread, so that results repeat.
inline ceres::Solver::Options sparse_solver(int iterations) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  if (!ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::SUITE_SPARSE))
    solver.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  solver.max_num_iterations = iterations;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  return solver;
}

}  // namespace rastro
