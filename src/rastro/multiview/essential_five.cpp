// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <array>
#include <cmath>

#include "rastro/multiview/essential.h"
#include "rastro/multiview/polynomial.h"

// Nister 2004. E = x X + y Y + z Z + W with the null space's four matrices; det E = 0 and 2 E E' E = tr(E E') E are ten
// cubics in x, y, z.

namespace rastro {
namespace {

struct Monomial {
  int x, y, z;
  constexpr bool operator==(const Monomial&) const = default;
};
constexpr std::array<Monomial, 4> linear_terms{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};
constexpr std::array<Monomial, 10> quadratic_terms{
    {{2, 0, 0}, {1, 1, 0}, {1, 0, 1}, {1, 0, 0}, {0, 2, 0}, {0, 1, 1}, {0, 1, 0}, {0, 0, 2}, {0, 0, 1}, {0, 0, 0}}};
/// In the order of the paper: the first ten are eliminated; the others contain x or y at most once and separately.
constexpr std::array<Monomial, 20> cubic_terms{
    {{3, 0, 0}, {0, 3, 0}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}, {2, 0, 0}, {0, 2, 1}, {0, 2, 0}, {1, 1, 1}, {1, 1, 0},
     {1, 0, 2}, {1, 0, 1}, {1, 0, 0}, {0, 1, 2}, {0, 1, 1}, {0, 1, 0}, {0, 0, 3}, {0, 0, 2}, {0, 0, 1}, {0, 0, 0}}};

/// Index in `products` of the product of term i of the one and term j of the linear terms.
template <std::size_t Count, std::size_t Products>
constexpr std::array<std::array<int, 4>, Count> product_indices(const std::array<Monomial, Count>& terms,
                                                                const std::array<Monomial, Products>& products) {
  std::array<std::array<int, 4>, Count> indices{};
  for (std::size_t i = 0; i < Count; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      const Monomial product{terms[i].x + linear_terms[j].x, terms[i].y + linear_terms[j].y,
                             terms[i].z + linear_terms[j].z};
      for (std::size_t k = 0; k < Products; ++k) {
        if (products[k] == product) indices[i][j] = static_cast<int>(k);
      }
    }
  }
  return indices;
}
constexpr auto to_quadratic = product_indices(linear_terms, quadratic_terms);
constexpr auto to_cubic = product_indices(quadratic_terms, cubic_terms);

using Linear = Eigen::Vector4d;
using Quadratic = Eigen::Matrix<double, 10, 1>;
using Cubic = Eigen::Matrix<double, 20, 1>;

void add_product(const Linear& a, const Linear& b, double factor, Quadratic& sum) {
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j)
      sum(to_quadratic[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]) += factor * a(i) * b(j);
  }
}

void add_product(const Quadratic& a, const Linear& b, Cubic& sum) {
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 4; ++j) sum(to_cubic[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]) += a(i) * b(j);
  }
}

using Basis = Eigen::Matrix<double, 9, 4>;
using Constraints = Eigen::Matrix<double, 10, 20>;

/// The four matrices, row by row, that span the null space of five pairs.
Basis null_space(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b, const std::uint32_t* indices) {
  Eigen::Matrix<double, 9, 5> columns;
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d p = a[indices[i]].homogeneous(), q = b[indices[i]].homogeneous();
    columns.col(i) << q.x() * p, q.y() * p, q.z() * p;
  }
  const Eigen::HouseholderQR<Eigen::Matrix<double, 9, 5>> qr(columns);
  Basis basis = Basis::Zero();
  basis.bottomRows<4>().setIdentity();
  return qr.householderQ() * basis;
}

Constraints constraints_of(const Basis& basis) {
  std::array<std::array<Linear, 3>, 3> e;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) e[r][c] = basis.row(static_cast<Eigen::Index>(3 * r + c)).transpose();
  }
  // E E' - tr(E E') / 2
  std::array<std::array<Quadratic, 3>, 3> square;
  Quadratic half_trace = Quadratic::Zero();
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c <= r; ++c) {
      square[r][c].setZero();
      for (std::size_t k = 0; k < 3; ++k) add_product(e[r][k], e[c][k], 1.0, square[r][c]);
      square[c][r] = square[r][c];
    }
    half_trace += 0.5 * square[r][r];
  }
  for (std::size_t r = 0; r < 3; ++r) square[r][r] -= half_trace;

  Constraints constraints;
  Eigen::Index row = 0;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      Cubic sum = Cubic::Zero();
      for (std::size_t k = 0; k < 3; ++k) add_product(square[r][k], e[k][c], sum);
      constraints.row(row++) = sum.transpose();
    }
  }
  Cubic determinant = Cubic::Zero();
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
    Quadratic minor = Quadratic::Zero();
    add_product(e[1][next], e[2][last], 1.0, minor);
    add_product(e[1][last], e[2][next], -1.0, minor);
    add_product(minor, e[0][c], determinant);
  }
  constraints.row(row) = determinant.transpose();
  return constraints;
}

/// A row of the paper's matrix B(z): x p + y q + r = 0 with polynomials in z, from the constant on.
struct Row {
  std::array<double, 4> p, q;
  std::array<double, 5> r;
};

/// Of two eliminated rows whose leading terms differ by a factor of z: upper - z lower.
template <typename Vector>
Row without_leading_term(const Vector& upper, const Vector& lower) {
  Row row;
  row.p = {upper(2), upper(1) - lower(2), upper(0) - lower(1), -lower(0)};
  row.q = {upper(5), upper(4) - lower(5), upper(3) - lower(4), -lower(3)};
  row.r = {upper(9), upper(8) - lower(9), upper(7) - lower(8), upper(6) - lower(7), -lower(6)};
  return row;
}

template <std::size_t N, std::size_t M>
std::array<double, N + M - 1> product(const std::array<double, N>& a, const std::array<double, M>& b) {
  std::array<double, N + M - 1> result{};
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = 0; j < M; ++j) result[i + j] += a[i] * b[j];
  }
  return result;
}

template <std::size_t N>
std::array<double, N> difference(std::array<double, N> a, const std::array<double, N>& b) {
  for (std::size_t i = 0; i < N; ++i) a[i] -= b[i];
  return a;
}

Polynomial determinant_of(const std::array<Row, 3>& rows) {
  const auto& [k, l, m] = rows;
  const auto with_p = product(k.p, difference(product(l.q, m.r), product(m.q, l.r)));
  const auto with_q = product(k.q, difference(product(m.p, l.r), product(l.p, m.r)));
  const auto with_r = product(k.r, difference(product(l.p, m.q), product(m.p, l.q)));
  Polynomial sum{};
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = with_p[i] + with_q[i] + with_r[i];
  return sum;
}

template <std::size_t N>
double value_at(const std::array<double, N>& c, double z) {
  double value = 0.0;
  for (std::size_t i = N; i-- > 0;) value = value * z + c[i];
  return value;
}

/// x and y for z: the kernel of B(z), as the longest of the cross products of its rows.
Eigen::Vector3d kernel_at(const std::array<Row, 3>& rows, double z) {
  std::array<Eigen::Vector3d, 3> values;
  for (std::size_t i = 0; i < 3; ++i)
    values[i] = {value_at(rows[i].p, z), value_at(rows[i].q, z), value_at(rows[i].r, z)};
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d cross = values[i].cross(values[(i + 1) % 3]);
    if (cross.squaredNorm() > best.squaredNorm()) best = cross;
  }
  return best;
}

}  // namespace

std::vector<Eigen::Matrix3d> essential_from_five(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                                                 const std::uint32_t* indices) {
  const Basis basis = null_space(a, b, indices);
  const Constraints constraints = constraints_of(basis);
  const Eigen::Matrix<double, 10, 10> eliminated =
      constraints.leftCols<10>().partialPivLu().solve(constraints.rightCols<10>());
  std::array<Row, 3> rows;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto upper = static_cast<Eigen::Index>(4 + 2 * i);
    rows[i] = without_leading_term(eliminated.row(upper), eliminated.row(upper + 1));
  }
  std::vector<Eigen::Matrix3d> models;
  for (const double z : real_roots(determinant_of(rows))) {
    const Eigen::Vector3d kernel = kernel_at(rows, z);
    const Eigen::Matrix<double, 9, 1> e = basis * Eigen::Vector4d(kernel.x(), kernel.y(), z * kernel.z(), kernel.z());
    const double length = e.norm();
    if (!std::isfinite(length) || length == 0.0) continue;
    models.push_back(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(e.data()) / length);
  }
  return models;
}

}  // namespace rastro
