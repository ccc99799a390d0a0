// SPDX-License-Identifier: Apache-2.0
// The laws of a Lie group and its derivatives, for every group in one suite.
#include "rastro/math/lie.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <numbers>
#include <vector>

#include "rastro/math/math_testing.h"
#include "rastro/math/se2.h"
#include "rastro/math/se3.h"
#include "rastro/math/sim3.h"
#include "rastro/math/so2.h"
#include "rastro/math/so3.h"

namespace rastro {
namespace {

using testing::matrix_near;
using testing::random_vector;

/// Position of the rotation in the tangent vector.
template <typename Group>
struct RotationPart;
template <>
struct RotationPart<SO2> {
  static constexpr int start = 0, size = 1;
};
template <>
struct RotationPart<SE2> {
  static constexpr int start = 2, size = 1;
};
template <>
struct RotationPart<SO3> {
  static constexpr int start = 0, size = 3;
};
template <>
struct RotationPart<SE3> {
  static constexpr int start = 3, size = 3;
};
template <>
struct RotationPart<Sim3> {
  static constexpr int start = 3, size = 3;
};

template <typename Group>
class LieGroup : public ::testing::Test {
 protected:
  using Tangent = typename Group::Tangent;
  using Point = typename Group::Point;
  using Part = RotationPart<Group>;
  static constexpr int dimension = Tangent::RowsAtCompileTime;

  /// A random tangent vector whose rotation has the given angle.
  Tangent tangent_of_angle(double angle) {
    Tangent tangent = random_vector<Tangent>(random_, 1.0);
    auto rotation = tangent.template segment<Part::size>(Part::start);
    rotation *= angle / rotation.norm();
    return tangent;
  }
  Tangent tangent() { return tangent_of_angle(random_.uniform(0.0, 3.0)); }
  Point point() { return random_vector<Point>(random_, 5.0); }

  /// Angles at which closed forms change to series, and at which logarithms wrap around.
  std::vector<Tangent> hard_tangents() {
    std::vector<Tangent> result = {Tangent::Zero()};
    for (const double angle : {1e-300, 1e-20, 1e-12, 1e-9, 1e-8, 1e-6, 9e-5, 1.1e-4, 1e-3, 0.01, 0.19, 0.21, 0.29, 0.31,
                               1.0, 3.0, std::numbers::pi - 1e-3, std::numbers::pi - 1e-6, std::numbers::pi - 1e-9})
      for (int i = 0; i < 5; ++i) result.push_back(tangent_of_angle(angle));
    return result;
  }

  Random random_{20};
};

using Groups = ::testing::Types<SO2, SE2, SO3, SE3, Sim3>;
TYPED_TEST_SUITE(LieGroup, Groups);

template <typename Group>
::testing::AssertionResult same(const Group& a, const Group& b, double tolerance) {
  const double error = (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
  if (error <= tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "matrices differ by " << error;
}

TYPED_TEST(LieGroup, ProductIsThatOfTheMatrices) {
  for (int i = 0; i < 100; ++i) {
    const auto a = TypeParam::exp(this->tangent()), b = TypeParam::exp(this->tangent());
    EXPECT_THAT((a * b).matrix(), matrix_near((a.matrix() * b.matrix()).eval(), 1e-13));
  }
}

TYPED_TEST(LieGroup, ProductIsAssociative) {
  for (int i = 0; i < 100; ++i) {
    const auto a = TypeParam::exp(this->tangent()), b = TypeParam::exp(this->tangent()),
               c = TypeParam::exp(this->tangent());
    EXPECT_TRUE(same((a * b) * c, a * (b * c), 1e-12));
  }
}

TYPED_TEST(LieGroup, IdentityChangesNothing) {
  const auto a = TypeParam::exp(this->tangent());
  EXPECT_TRUE(same(a * TypeParam(), a, 1e-15));
  EXPECT_TRUE(same(TypeParam() * a, a, 1e-15));
  EXPECT_EQ(TypeParam().log().norm(), 0.0);
}

TYPED_TEST(LieGroup, InverseUndoes) {
  for (int i = 0; i < 100; ++i) {
    const auto a = TypeParam::exp(this->tangent());
    EXPECT_TRUE(same(a * a.inverse(), TypeParam(), 1e-13));
    EXPECT_TRUE(same(a.inverse() * a, TypeParam(), 1e-13));
  }
}

TYPED_TEST(LieGroup, ActsOnPointsLikeItsProduct) {
  for (int i = 0; i < 100; ++i) {
    const auto a = TypeParam::exp(this->tangent()), b = TypeParam::exp(this->tangent());
    const auto p = this->point();
    EXPECT_THAT((a * b) * p, matrix_near((a * (b * p)).eval(), 1e-12));
  }
}

TYPED_TEST(LieGroup, LogUndoesExp) {
  for (const auto& tangent : this->hard_tangents())
    EXPECT_THAT(TypeParam::exp(tangent).log(), matrix_near(tangent, 1e-12)) << tangent.transpose();
}

TYPED_TEST(LieGroup, ExpUndoesLogAtAndBeyondARotationByPi) {
  for (const double beyond : {0.0, 1e-12, 1e-6, 0.1, 2.0}) {
    const auto a = TypeParam::exp(this->tangent_of_angle(std::numbers::pi + beyond));
    EXPECT_TRUE(same(TypeParam::exp(a.log()), a, 1e-12)) << beyond;
  }
}

TYPED_TEST(LieGroup, ExpIsTheMatrixExponential) {
  // exp(x) = exp(x / 2^k)^(2^k): first-order accurate pieces, squared, differ from the closed form by O(2^-k).
  for (const auto& tangent : this->hard_tangents()) {
    auto product = TypeParam::exp(tangent / 1024.0).matrix();
    for (int i = 0; i < 10; ++i) product = (product * product).eval();
    EXPECT_THAT(TypeParam::exp(tangent).matrix(), matrix_near(product, 1e-11));
  }
}

TYPED_TEST(LieGroup, SmallTangentsAreKeptToTheirLastDigits) {
  for (const double size : {1e-5, 1e-8, 1e-12, 1e-100}) {
    auto tangent = (size * this->tangent()).eval();
    // 1 + 1e-12 has no more digits to recover.
    if constexpr (std::is_same_v<TypeParam, Sim3>) tangent[6] = 0.0;
    const auto error = (TypeParam::exp(tangent).log() - tangent).eval();
    EXPECT_LT(error.norm(), 1e-14 * tangent.norm()) << size;
  }
}

TYPED_TEST(LieGroup, AdjointMovesATangentAcross) {
  for (int i = 0; i < 50; ++i) {
    const auto a = TypeParam::exp(this->tangent());
    const auto v = (0.3 * this->tangent()).eval();
    const typename TestFixture::Tangent moved = a.adjoint() * v;
    EXPECT_TRUE(same(TypeParam::exp(moved), a * TypeParam::exp(v) * a.inverse(), 1e-12));
  }
}

TYPED_TEST(LieGroup, AdjointOfAProduct) {
  const auto a = TypeParam::exp(this->tangent()), b = TypeParam::exp(this->tangent());
  EXPECT_THAT((a * b).adjoint(), matrix_near((a.adjoint() * b.adjoint()).eval(), 1e-12));
}

TYPED_TEST(LieGroup, SmallAdjointIsTheDerivativeOfTheAdjoint) {
  const auto v = this->tangent();
  constexpr double step = 1e-6;
  const auto numeric =
      ((TypeParam::exp(step * v).adjoint() - TypeParam::exp(-step * v).adjoint()) / (2.0 * step)).eval();
  EXPECT_THAT(TypeParam::small_adjoint(v), matrix_near(numeric, 1e-8));
}

TYPED_TEST(LieGroup, JacobiansAgainstFiniteDifferences) {
  constexpr double step = 1e-6;
  for (const auto& tangent : this->hard_tangents()) {
    const auto right = right_jacobian<TypeParam>(tangent);
    const auto left = left_jacobian<TypeParam>(tangent);
    const auto inverse = TypeParam::exp(tangent).inverse();
    for (int i = 0; i < TestFixture::dimension; ++i) {
      const typename TestFixture::Tangent change = step * TestFixture::Tangent::Unit(i);
      const auto ahead = TypeParam::exp(tangent + change), behind = TypeParam::exp(tangent - change);
      const typename TestFixture::Tangent by_right =
          ((inverse * ahead).log() - (inverse * behind).log()) / (2.0 * step);
      const typename TestFixture::Tangent by_left = ((ahead * inverse).log() - (behind * inverse).log()) / (2.0 * step);
      EXPECT_THAT(right.col(i), matrix_near(by_right, 1e-8));
      EXPECT_THAT(left.col(i), matrix_near(by_left, 1e-8));
    }
  }
}

TYPED_TEST(LieGroup, InterpolationHasItsEndsAndIsEven) {
  for (int i = 0; i < 50; ++i) {
    const auto a = TypeParam::exp(this->tangent()), b = TypeParam::exp(this->tangent());
    EXPECT_TRUE(same(interpolate(a, b, 0.0), a, 1e-12));
    EXPECT_TRUE(same(interpolate(a, b, 1.0), b, 1e-12));
    const auto middle = interpolate(a, b, 0.5);
    EXPECT_TRUE(same(interpolate(a, middle, 0.5), interpolate(a, b, 0.25), 1e-11));
    const auto c = TypeParam::exp(this->tangent());
    EXPECT_TRUE(same(c * middle, interpolate(c * a, c * b, 0.5), 1e-11)) << "depends on the choice of the world frame";
  }
}

TYPED_TEST(LieGroup, LongProductsStayInTheGroup) {
  auto product = TypeParam();
  const auto step = TypeParam::exp((1e-3 * this->tangent()).eval());
  for (int i = 0; i < 100000; ++i) product = product * step;
  const auto rotation = product.matrix().template topLeftCorner<2, 2>().eval();
  EXPECT_TRUE(rotation.allFinite());
  EXPECT_TRUE(same(product * product.inverse(), TypeParam(), 1e-9));
}

TYPED_TEST(LieGroup, NotANumberStaysVisible) {
  auto tangent = this->tangent();
  tangent[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(TypeParam::exp(tangent).matrix().allFinite());
  EXPECT_FALSE(TypeParam::exp(tangent).log().allFinite());
}

}  // namespace
}  // namespace rastro
