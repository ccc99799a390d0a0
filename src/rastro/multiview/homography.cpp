// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/homography.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "rastro/multiview/ransac.h"

namespace rastro {
namespace {

/// The matrix that maps the projective basis (e1, e2, e3, e1+e2+e3) to four points; nullopt if three lie on a line.
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

/// One Gauss-Newton step of the distances in image b over the inliers, in normalized coordinates.
class HomographyProblem {
 public:
  static constexpr std::size_t sample_size = 4;
  explicit HomographyProblem(const PointPairs& pairs) : pairs_(pairs) {}

  template <typename Sink>
  void fit(const std::array<std::uint32_t, 4>& sample, Sink&& sink) const {
    if (const auto model = homography_from_four(pairs_, sample.data())) sink(*model);
  }

  void errors(const Eigen::Matrix3d& h, float* out) const {
    // In floats and plain arrays, so that the compiler vectorises it.
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
    // Every row of the Jacobian is (a/w, 0, -u p) or (0, a/w, -v p) with a = (x, y, 1) and p = (x, y)/w, so the normal
    // equations consist of few sums: of a a', u a p', v a p' and (u^2 + v^2) p p'.
    double axx = 0, axy = 0, ax = 0, ayy = 0, ay = 0, a1 = 0, uxx = 0, uxy = 0, ux = 0, uyy = 0, uy = 0;
    double vxx = 0, vxy = 0, vx = 0, vyy = 0, vy = 0, wxx = 0, wxy = 0, wyy = 0;
    Eigen::Matrix<double, 8, 1> right = Eigen::Matrix<double, 8, 1>::Zero();
    const double h00 = h(0, 0), h01 = h(0, 1), h02 = h(0, 2), h10 = h(1, 0), h11 = h(1, 1), h12 = h(1, 2);
    const double h20 = h(2, 0), h21 = h(2, 1);
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (!(best.squared_errors[i] <= limit)) continue;
      const double x = static_cast<double>(pairs_.ax[i]) / unit, y = static_cast<double>(pairs_.ay[i]) / unit;
      const double inverse = 1.0 / (h20 * x + h21 * y + 1.0);
      const double u = (h00 * x + h01 * y + h02) * inverse, v = (h10 * x + h11 * y + h12) * inverse;
      const double px = x * inverse, py = y * inverse, p1 = inverse;
      const double du = static_cast<double>(pairs_.bx[i]) / unit - u, dv = static_cast<double>(pairs_.by[i]) / unit - v;
      const double pxx = px * px, pxy = px * py, pyy = py * py, pxo = px * p1, pyo = py * p1, squares = u * u + v * v;
      axx += pxx, axy += pxy, ax += pxo, ayy += pyy, ay += pyo, a1 += p1 * p1;
      uxx += u * pxx, uxy += u * pxy, ux += u * pxo, uyy += u * pyy, uy += u * pyo;
      vxx += v * pxx, vxy += v * pxy, vx += v * pxo, vyy += v * pyy, vy += v * pyo;
      wxx += squares * pxx, wxy += squares * pxy, wyy += squares * pyy;
      const double both = u * du + v * dv;
      right(0) += px * du, right(1) += py * du, right(2) += p1 * du;
      right(3) += px * dv, right(4) += py * dv, right(5) += p1 * dv;
      right(6) -= px * both, right(7) -= py * both;
    }
    Eigen::Matrix<double, 8, 8> normal;
    normal << axx, axy, ax, 0, 0, 0, -uxx, -uxy,  //
        axy, ayy, ay, 0, 0, 0, -uxy, -uyy,        //
        ax, ay, a1, 0, 0, 0, -ux, -uy,            //
        0, 0, 0, axx, axy, ax, -vxx, -vxy,        //
        0, 0, 0, axy, ayy, ay, -vxy, -vyy,        //
        0, 0, 0, ax, ay, a1, -vx, -vy,            //
        -uxx, -uxy, -ux, -vxx, -vxy, -vx, wxx, wxy, -uxy, -uyy, -uy, -vxy, -vyy, -vy, wxy, wyy;
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
  // The sign of the last coordinate is that of the image center: a point with another sign passed through infinity.
  if (std::abs(image.z()) < 1e-12) return std::nullopt;
  return Eigen::Vector2d(image.hnormalized());
}

}  // namespace rastro
