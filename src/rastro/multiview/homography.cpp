// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/homography.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "rastro/multiview/ransac.h"

namespace rastro {
namespace {

/// The matrix that maps the projective basis (e1, e2, e3, e1+e2+e3) to four points; nullopt when three lie on a line.
std::optional<Eigen::Matrix3d> basis_to(const Eigen::Vector2d (&points)[4]) {
  Eigen::Matrix3d corners;
  for (int i = 0; i < 3; ++i) corners.col(i) = points[i].homogeneous();
  const double area = corners.determinant();
  if (std::abs(area) < 1e-3) return std::nullopt;
  Eigen::Vector3d weights;
  const Eigen::Vector3d last = points[3].homogeneous();
  weights.x() = last.dot(corners.col(1).cross(corners.col(2)));
  weights.y() = last.dot(corners.col(2).cross(corners.col(0)));
  weights.z() = last.dot(corners.col(0).cross(corners.col(1)));
  if (weights.cwiseAbs().minCoeff() < 1e-3) return std::nullopt;
  return corners * (weights / area).asDiagonal();
}

/// One Gauss-Newton step of the distances in image b over the inliers, in coordinates brought to unit size.
class HomographyProblem {
 public:
  static constexpr std::size_t sample_size = 4;
  explicit HomographyProblem(const PointPairs& pairs) : pairs_(pairs) {}

  template <typename Sink>
  void fit(const std::array<std::uint32_t, 4>& sample, Sink&& sink) const {
    if (const auto model = homography_from_four(pairs_, sample.data())) sink(*model);
  }

  void errors(const Eigen::Matrix3d& h, float* out) const {
    // In floats and plain arrays, so that the compiler makes vectors of it.
    const Eigen::Matrix3f m = (h / h.norm()).cast<float>();
    const float h00 = m(0, 0), h01 = m(0, 1), h02 = m(0, 2), h10 = m(1, 0), h11 = m(1, 1), h12 = m(1, 2);
    const float h20 = m(2, 0), h21 = m(2, 1), h22 = m(2, 2);
    const float *ax = pairs_.ax.data(), *ay = pairs_.ay.data(), *bx = pairs_.bx.data(), *by = pairs_.by.data();
    for (std::size_t i = 0, count = pairs_.size(); i < count; ++i) {
      const float inverse = 1.0F / (h20 * ax[i] + h21 * ay[i] + h22);
      const float dx = (h00 * ax[i] + h01 * ay[i] + h02) * inverse - bx[i];
      const float dy = (h10 * ax[i] + h11 * ay[i] + h12) * inverse - by[i];
      out[i] = dx * dx + dy * dy;
    }
  }

  std::optional<Eigen::Matrix3d> refit(const RobustFit& best, float limit) const {
    if (best.inliers < 5 || std::abs(best.model(2, 2)) < 1e-12) return std::nullopt;
    // Coordinates in units of about the image keep the normal equations well conditioned.
    constexpr double unit = 500.0;
    const Eigen::DiagonalMatrix<double, 3> to_units(1.0 / unit, 1.0 / unit, 1.0);
    const Eigen::DiagonalMatrix<double, 3> from_units(unit, unit, 1.0);
    Eigen::Matrix3d h = to_units * best.model * from_units;
    h /= h(2, 2);
    Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
    Eigen::Matrix<double, 8, 1> right = Eigen::Matrix<double, 8, 1>::Zero();
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (!(best.squared_errors[i] <= limit)) continue;
      const Eigen::Vector2d a = pairs_.a(i) / unit, b = pairs_.b(i) / unit;
      const double w = h(2, 0) * a.x() + h(2, 1) * a.y() + 1.0;
      const double u = (h(0, 0) * a.x() + h(0, 1) * a.y() + h(0, 2)) / w;
      const double v = (h(1, 0) * a.x() + h(1, 1) * a.y() + h(1, 2)) / w;
      Eigen::Matrix<double, 8, 1> du, dv;
      du << a.x() / w, a.y() / w, 1.0 / w, 0.0, 0.0, 0.0, -u * a.x() / w, -u * a.y() / w;
      dv << 0.0, 0.0, 0.0, a.x() / w, a.y() / w, 1.0 / w, -v * a.x() / w, -v * a.y() / w;
      normal.selfadjointView<Eigen::Lower>().rankUpdate(du);
      normal.selfadjointView<Eigen::Lower>().rankUpdate(dv);
      right += du * (b.x() - u) + dv * (b.y() - v);
    }
    const Eigen::LDLT<Eigen::Matrix<double, 8, 8>, Eigen::Lower> solver(normal);
    if (solver.info() != Eigen::Success) return std::nullopt;
    const Eigen::Matrix<double, 8, 1> step = solver.solve(right);
    if (!step.allFinite()) return std::nullopt;
    h.row(0) += step.segment<3>(0).transpose();
    h.row(1) += step.segment<3>(3).transpose();
    h(2, 0) += step(6);
    h(2, 1) += step(7);
    return Eigen::Matrix3d(from_units * h * to_units);
  }

 private:
  const PointPairs& pairs_;
};

}  // namespace

std::optional<Eigen::Matrix3d> homography_from_four(const PointPairs& pairs, const std::uint32_t* indices) {
  Eigen::Vector2d a[4], b[4];
  for (int i = 0; i < 4; ++i) {
    a[i] = pairs.a(indices[i]);
    b[i] = pairs.b(indices[i]);
  }
  const auto a_from_basis = basis_to(a);
  if (!a_from_basis) return std::nullopt;
  const auto b_from_basis = basis_to(b);
  if (!b_from_basis) return std::nullopt;
  const Eigen::Matrix3d h = *b_from_basis * a_from_basis->inverse();
  return h.allFinite() ? std::optional(h) : std::nullopt;
}

std::optional<RobustFit> estimate_homography(const PointPairs& pairs, const RansacOptions& options) {
  return ransac(HomographyProblem(pairs), pairs, options);
}

std::optional<RobustFit> refine_homography(const PointPairs& pairs, const Eigen::Matrix3d& start, double max_error_px) {
  const HomographyProblem problem(pairs);
  const auto limit = static_cast<float>(max_error_px * max_error_px);
  RobustFit fit;
  const auto judge = [&](const Eigen::Matrix3d& model) {
    fit.model = model;
    fit.squared_errors.resize(pairs.size());
    problem.errors(model, fit.squared_errors.data());
    fit.inliers = static_cast<int>(
        std::count_if(fit.squared_errors.begin(), fit.squared_errors.end(), [=](float e) { return e <= limit; }));
  };
  judge(start);
  const auto refined = problem.refit(fit, limit);
  if (!refined) return std::nullopt;
  judge(*refined);
  return fit;
}

std::optional<Eigen::Vector2d> transfer(const Eigen::Matrix3d& homography, const Eigen::Vector2d& point) {
  const Eigen::Vector3d image = homography * point.homogeneous();
  // The sign of the last coordinate is that of the plane's middle: a point that changes it went through infinity.
  if (std::abs(image.z()) < 1e-12) return std::nullopt;
  return Eigen::Vector2d(image.hnormalized());
}

}  // namespace rastro
