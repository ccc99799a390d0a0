// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace rastro::detail {

/// Cube indices, 16 bits per axis as in OctoMap: packed x | y << 16 | z << 32.
using CellKey = std::uint64_t;

/// The cubes in which the rays of one image end and through which they pass.
class RayCells {
 public:
  RayCells(const Eigen::Vector3d& origin, double resolution_m);
  /// Adds a ray that ends at `end`; `hit`: on a surface.
  void add(const Eigen::Vector3d& end, bool hit);
  /// Sorts and removes duplicates; a cube that was hit is not free.
  void finish();
  const std::vector<CellKey>& hits() const { return hits_; }
  const std::vector<CellKey>& free() const { return free_; }

 private:
  struct Ray {
    CellKey cell = 0;
    Eigen::Vector3d end = Eigen::Vector3d::Zero();
  };
  bool is_inside(const Eigen::Vector3d& position) const;
  CellKey cell_of(const Eigen::Vector3d& position) const;
  void pass(const Ray& ray);

  Eigen::Vector3d origin_;
  double resolution_m_;
  std::vector<Ray> rays_;
  std::vector<CellKey> hits_, free_;
};

}  // namespace rastro::detail
