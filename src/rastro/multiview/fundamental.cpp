// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/fundamental.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "rastro/multiview/polynomial.h"
#include "rastro/multiview/ransac.h"
#include "rastro/multiview/sampson_errors.h"

namespace rastro {
namespace {

using Row9 = Eigen::Matrix<double, 1, 9>;
// Pixels in units of about the image, so that the nine terms have similar magnitudes.
constexpr double unit = 500.0;

Row9 epipolar_row(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  Row9 row;
  row << b.x() * a.x(), b.x() * a.y(), b.x(), b.y() * a.x(), b.y() * a.y(), b.y(), a.x(), a.y(), 1.0;
  return row;
}

Eigen::Matrix3d matrix_of(const Eigen::Matrix<double, 9, 1>& v) {
  Eigen::Matrix3d f;
  f << v(0), v(1), v(2), v(3), v(4), v(5), v(6), v(7), v(8);
  return f;
}

Eigen::Matrix3d in_pixels(const Eigen::Matrix3d& f) {
  const Eigen::DiagonalMatrix<double, 3> to_units(1.0 / unit, 1.0 / unit, 1.0);
  return to_units * f * to_units;
}

/// det(x F1 + (1 - x) F2) as a cubic in x, from its values at four points.
std::vector<double> roots_of_determinant(const Eigen::Matrix3d& f1, const Eigen::Matrix3d& f2) {
  const auto determinant = [&](double x) { return (x * f1 + (1.0 - x) * f2).determinant(); };
  const double at0 = determinant(0.0), at1 = determinant(1.0), atm = determinant(-1.0), at2 = determinant(2.0);
  const double c0 = at0, c2 = 0.5 * (at1 + atm) - at0;
  const double odd = 0.5 * (at1 - atm);                       // c1 + c3
  const double c3 = (at2 - 4.0 * c2 - c0 - 2.0 * odd) / 6.0;  // at2 = c0 + 2 c1 + 4 c2 + 8 c3
  return cubic_roots(c3, c2, odd - c3, c0);
}

class FundamentalProblem {
 public:
  static constexpr std::size_t sample_size = 7;
  explicit FundamentalProblem(const PointPairs& pairs) : pairs_(pairs) {}

  template <typename Sink>
  void fit(const std::array<std::uint32_t, 7>& sample, Sink&& sink) const {
    for (const Eigen::Matrix3d& model : fundamental_from_seven(pairs_, sample.data())) sink(model);
  }

  void errors(const Eigen::Matrix3d& fundamental, float* out) const {
    sampson_errors((fundamental / fundamental.norm()).cast<float>(), pairs_, out);
  }

  /// Eight-point solution on the inliers, reduced to rank two.
  std::optional<Eigen::Matrix3d> refit(const RobustFit& best, float limit) const {
    if (best.inliers < 9) return std::nullopt;
    Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (!(best.squared_errors[i] <= limit)) continue;
      const Row9 row = epipolar_row(centered(pairs_.a(i)), centered(pairs_.b(i)));
      normal.selfadjointView<Eigen::Lower>().rankUpdate(row.transpose());
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(normal);
    if (eigen.info() != Eigen::Success) return std::nullopt;
    Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix_of(eigen.eigenvectors().col(0)),
                                          Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Vector3d values(svd.singularValues().x(), svd.singularValues().y(), 0.0);
    return uncentered(svd.matrixU() * values.asDiagonal() * svd.matrixV().transpose());
  }

 private:
  // The centroid of the points as origin and their spread as unit: Hartley's conditioning with fixed numbers suffices
  // here.
  static Eigen::Vector2d centered(const Eigen::Vector2d& p) { return (p - Eigen::Vector2d(middle, middle)) / unit; }
  static Eigen::Matrix3d uncentered(const Eigen::Matrix3d& f) {
    Eigen::Matrix3d to_units;
    to_units << 1.0 / unit, 0.0, -middle / unit, 0.0, 1.0 / unit, -middle / unit, 0.0, 0.0, 1.0;
    return to_units.transpose() * f * to_units;
  }
  static constexpr double middle = 300.0;
  const PointPairs& pairs_;
};

}  // namespace

std::vector<Eigen::Matrix3d> fundamental_from_seven(const PointPairs& pairs, const std::uint32_t* indices) {
  Eigen::Matrix<double, 7, 9> rows;
  for (int i = 0; i < 7; ++i) rows.row(i) = epipolar_row(pairs.a(indices[i]) / unit, pairs.b(indices[i]) / unit);
  const Eigen::FullPivLU<Eigen::Matrix<double, 7, 9>> lu(rows);
  if (lu.dimensionOfKernel() != 2) return {};
  const Eigen::Matrix<double, 9, 2> kernel = lu.kernel();
  const Eigen::Matrix3d f1 = matrix_of(kernel.col(0).normalized()), f2 = matrix_of(kernel.col(1).normalized());
  std::vector<Eigen::Matrix3d> models;
  for (const double x : roots_of_determinant(f1, f2)) {
    const Eigen::Matrix3d f = in_pixels(x * f1 + (1.0 - x) * f2);
    if (f.allFinite() && f.norm() > 0.0) models.push_back(f);
  }
  return models;
}

std::optional<RobustFit> estimate_fundamental(const PointPairs& pairs, const RansacOptions& options) {
  return ransac(FundamentalProblem(pairs), pairs, options);
}

double sampson_distance_squared(const Eigen::Matrix3d& fundamental, const Eigen::Vector2d& a,
                                const Eigen::Vector2d& b) {
  const Eigen::Vector3d line_b = fundamental * a.homogeneous(), line_a = fundamental.transpose() * b.homogeneous();
  const double value = b.homogeneous().dot(line_b);
  return value * value / (line_b.head<2>().squaredNorm() + line_a.head<2>().squaredNorm() + 1e-30);
}

}  // namespace rastro
