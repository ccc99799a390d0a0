// SPDX-License-Identifier: Apache-2.0
// Properties of every camera model, with OpenCV's models as the oracle.
#include "rastro/camera/camera.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "rastro/base/random.h"
#include "rastro/camera/distortion.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using rastro::testing::matrix_near;

struct NamedCamera {
  const char* name;
  Camera camera;
};

std::ostream& operator<<(std::ostream& stream, const NamedCamera& named) { return stream << named.name; }

const NamedCamera cameras[] = {
    {"pinhole", {640, 480, 585.0, 585.0, 320.0, 240.0, Distortion::none, {}}},
    {"euroc_barrel",
     {752,
      480,
      458.654,
      457.296,
      367.215,
      248.375,
      Distortion::radial_tangential,
      {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}}},
    {"freiburg1_mixed",
     {640, 480, 517.3, 516.5, 318.6, 255.3, Distortion::radial_tangential, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}}},
    {"pincushion",
     {640, 480, 500.0, 505.0, 330.0, 235.0, Distortion::radial_tangential, {0.2, 0.05, 0.001, -0.002, 0.01}}},
    {"strong_tangential",
     {640, 480, 500.0, 505.0, 330.0, 235.0, Distortion::radial_tangential, {-0.1, 0.0, 0.02, -0.03}}},
    {"fisheye",
     {752, 480, 461.487, 460.152, 362.681, 246.067, Distortion::equidistant, {-0.0270, 0.0116, -0.0123, 0.0044}}},
    {"wide_fisheye",
     {512, 512, 190.978, 190.973, 254.93, 256.897, Distortion::equidistant, {0.00348, 0.000715, -0.00205, 0.000203}}},
    {"rational_wide",
     {640, 480, 220.0, 223.0, 322.0, 236.0, Distortion::rational, {0.5, -0.3, 0.0004, -0.0003, 0.3, 0.6, 0.1, 0.3}}},
};

class CameraModel : public ::testing::TestWithParam<NamedCamera> {
 protected:
  const Camera& camera() const { return GetParam().camera; }

  /// Points in front of the camera that project into (or near) the image.
  std::vector<Eigen::Vector3d> points(int count) {
    std::vector<Eigen::Vector3d> result;
    while (static_cast<int>(result.size()) < count) {
      const Eigen::Vector2d pixel(random_.uniform(0.0, camera().width), random_.uniform(0.0, camera().height));
      if (const auto ray = camera().unproject(pixel)) result.push_back(random_.uniform(0.2, 20.0) * ray->homogeneous());
    }
    return result;
  }
  Random random_{7};
};

INSTANTIATE_TEST_SUITE_P(Models, CameraModel, ::testing::ValuesIn(cameras),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(CameraModel, UnprojectThenProjectGivesThePixel) {
  int without_ray = 0;
  for (int y = -1; y <= camera().height; y += 3)
    for (int x = -1; x <= camera().width; x += 3) {
      const Eigen::Vector2d pixel(x, y);
      const auto ray = camera().unproject(pixel);
      if (!ray) {
        ++without_ray;
        continue;
      }
      const auto back = camera().project(ray->homogeneous());
      ASSERT_TRUE(back) << pixel.transpose() << " has a ray that is not imaged";
      EXPECT_LT((*back - pixel).norm(), 1e-9 * camera().width) << pixel.transpose();
    }
  // The corners of the widest lens face backwards (its image circle ends at 300 pixels from the center).
  EXPECT_LE(without_ray, std::string(GetParam().name) == "wide_fisheye" ? 170 * 170 / 10 : 0);
}

TEST_P(CameraModel, ProjectThenUnprojectGivesTheRay) {
  for (const auto& point : points(2000)) {
    const auto pixel = camera().project(point);
    ASSERT_TRUE(pixel);
    const auto ray = camera().unproject(*pixel);
    ASSERT_TRUE(ray);
    EXPECT_LT((*ray - point.hnormalized()).norm(), 1e-10 * (1.0 + point.hnormalized().squaredNorm()));
  }
}

TEST_P(CameraModel, JacobianAgainstFiniteDifferences) {
  for (const auto& point : points(500)) {
    Eigen::Matrix<double, 2, 3> jacobian, numeric;
    const auto pixel = camera().project(point, jacobian);
    ASSERT_TRUE(pixel);
    EXPECT_EQ(*pixel, *camera().project(point));
    const double step = 1e-6 * point.z();
    for (int i = 0; i < 3; ++i) {
      const auto ahead = camera().project(point + step * Eigen::Vector3d::Unit(i));
      const auto behind = camera().project(point - step * Eigen::Vector3d::Unit(i));
      ASSERT_TRUE(ahead && behind);
      numeric.col(i) = (*ahead - *behind) / (2.0 * step);
    }
    EXPECT_THAT(jacobian, matrix_near(numeric, 1e-6 * (1.0 + numeric.norm())));
  }
}

TEST_P(CameraModel, JacobianOnTheAxisIsThatOfAPinhole) {
  Eigen::Matrix<double, 2, 3> jacobian, expected;
  ASSERT_TRUE(camera().project({0.0, 0.0, 2.0}, jacobian));
  expected << camera().fx / 2.0, 0.0, 0.0, 0.0, camera().fy / 2.0, 0.0;
  EXPECT_THAT(jacobian, matrix_near(expected, 1e-12));
}

TEST_P(CameraModel, ProjectsAsOpenCvDoes) {
  const auto in_space = points(300);
  std::vector<cv::Point3d> objects;
  objects.reserve(in_space.size());
  for (const auto& p : in_space) objects.emplace_back(p.x(), p.y(), p.z());
  const cv::Matx33d matrix(camera().fx, 0, camera().cx, 0, camera().fy, camera().cy, 0, 0, 1);
  const auto& k = camera().coefficients;
  std::vector<cv::Point2d> pixels;
  if (camera().distortion == Distortion::equidistant)
    cv::fisheye::projectPoints(objects, pixels, cv::Vec3d::all(0), cv::Vec3d::all(0), matrix,
                               cv::Vec4d(k[0], k[1], k[2], k[3]));
  else
    cv::projectPoints(objects, cv::Vec3d::all(0), cv::Vec3d::all(0), matrix, std::vector<double>(k.begin(), k.end()),
                      pixels);
  for (std::size_t i = 0; i < objects.size(); ++i)
    EXPECT_THAT(*camera().project(in_space[i]), matrix_near(Eigen::Vector2d(pixels[i].x, pixels[i].y), 1e-9));
}

TEST_P(CameraModel, APointNotInFrontOrNotANumberHasNoPixel) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  Eigen::Matrix<double, 2, 3> jacobian;
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(nan, 0, 1),
        Eigen::Vector3d(0, 0, nan), Eigen::Vector3d(inf, 0, 1), Eigen::Vector3d(1, 1, 1e-320)}) {
    EXPECT_FALSE(camera().project(point)) << point.transpose();
    EXPECT_FALSE(camera().project(point, jacobian)) << point.transpose();
  }
  EXPECT_FALSE(camera().unproject({nan, 1.0}));
  EXPECT_FALSE(camera().unproject({1.0, inf}));
}

TEST_P(CameraModel, FarOutsideTheImageARayEitherRoundTripsOrIsRefused) {
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d pixel(random_.uniform(-5000.0, 5000.0), random_.uniform(-5000.0, 5000.0));
    const auto ray = camera().unproject(pixel);
    if (!ray) continue;
    const auto back = camera().project(ray->homogeneous());
    ASSERT_TRUE(back) << pixel.transpose();
    EXPECT_LT((*back - pixel).norm(), 1e-6) << pixel.transpose();
  }
}

TEST_P(CameraModel, ScaledHasTheSameRays) {
  const Camera half = camera().scaled(0.5), triple = camera().scaled(3.0);
  EXPECT_EQ(half.width, (camera().width + 1) / 2);
  for (const auto& point : points(100)) {
    const Eigen::Vector2d corner(-0.5, -0.5);
    const Eigen::Vector2d from_corner = *camera().project(point) - corner;
    EXPECT_THAT(*half.project(point), matrix_near((corner + 0.5 * from_corner).eval(), 1e-10));
    EXPECT_THAT(*triple.project(point), matrix_near((corner + 3.0 * from_corner).eval(), 1e-10));
  }
}

TEST(Distortion, FoldsBackWhereTheDerivativeOfTheRadiusIsZero) {
  Camera camera = cameras[0].camera;
  camera.distortion = Distortion::radial_tangential;
  camera.coefficients = {-0.3};  // r (1 - 0.3 r^2) has its maximum at r^2 = 1 / 0.9.
  const double top = std::sqrt(1.0 / 0.9);
  EXPECT_NEAR(monotonic_radius(camera), top, 1e-12);
  EXPECT_TRUE(camera.project({0.999 * top, 0.0, 1.0}));
  EXPECT_FALSE(camera.project({1.001 * top, 0.0, 1.0}));
  EXPECT_FALSE(camera.project({2.0, 0.0, 1.0}));  // Would be inside the image.
  const double widest = camera.fx * top * (1.0 - 0.3 * top * top);
  EXPECT_TRUE(camera.unproject({camera.cx + 0.9999 * widest, camera.cy}));
  EXPECT_FALSE(camera.unproject({camera.cx + 1.0001 * widest, camera.cy}));
}

TEST(Distortion, ARayBeyondAFoldIsRefusedEvenWhereTheModelGrowsAgain) {
  Camera camera = cameras[0].camera;
  camera.distortion = Distortion::radial_tangential;
  camera.coefficients = {-1.0, 0.4};  // 1 - 3 x + 2 x^2 = (1 - x)(1 - 2 x).
  EXPECT_NEAR(monotonic_radius(camera), std::sqrt(0.5), 1e-12);
  EXPECT_FALSE(camera.project({1.5, 0.0, 1.0}));
  camera.distortion = Distortion::equidistant;
  camera.coefficients = {-4.03 / 3.0, 0.8};  // 1 - 4.03 x + 4 x^2: below zero only from 0.442 to 0.565.
  EXPECT_NEAR(monotonic_radius(camera), std::tan(std::sqrt((4.03 - std::sqrt(4.03 * 4.03 - 16.0)) / 8.0)), 1e-9);
  EXPECT_FALSE(camera.project({1.5, 0.0, 1.0}));
}

TEST(Distortion, TheRationalModelFoldsWhereItsRadiusIsLargestOrItsDenominatorIsZero) {
  Camera camera = cameras[0].camera;
  camera.distortion = Distortion::rational;
  camera.coefficients = {0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0};  // r / (1 + r^2) has its maximum at 1.
  EXPECT_NEAR(monotonic_radius(camera), 1.0, 1e-12);
  EXPECT_TRUE(camera.unproject({camera.cx + 0.4999 * camera.fx, camera.cy}));
  EXPECT_FALSE(camera.unproject({camera.cx + 0.5001 * camera.fx, camera.cy}));
  camera.coefficients = {0.0, 0.0, 0.0, 0.0, 0.0, -0.25, 0.0, 0.0};  // A pole at 2, and growing beyond it too.
  EXPECT_NEAR(monotonic_radius(camera), 2.0, 1e-9);
  EXPECT_FALSE(camera.project({2.5, 0.0, 1.0}));
  camera.coefficients = {0.1, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0};  // Numerator and denominator are the same.
  EXPECT_TRUE(std::isinf(monotonic_radius(camera)));
}

TEST(Distortion, WithoutDistortionNothingFolds) {
  Camera camera = cameras[0].camera;
  EXPECT_TRUE(std::isinf(monotonic_radius(camera)));
  camera.distortion = Distortion::radial_tangential;
  EXPECT_TRUE(std::isinf(monotonic_radius(camera)));
  camera.distortion = Distortion::equidistant;
  EXPECT_TRUE(std::isinf(monotonic_radius(camera)));
}

TEST(Distortion, AbsurdCoefficientsNeverHangOrCrash) {
  Random random(11);
  for (int i = 0; i < 3000; ++i) {
    Camera camera = cameras[i % 2].camera;
    constexpr Distortion models[] = {Distortion::equidistant, Distortion::radial_tangential, Distortion::rational};
    camera.distortion = models[i % 3];
    const double size = std::pow(10.0, random.uniform(-3.0, i % 50 ? 3.0 : 300.0));
    for (auto& value : camera.coefficients) value = random.uniform(-size, size);
    const Eigen::Vector2d pixel(random.uniform(0.0, 640.0), random.uniform(0.0, 480.0));
    const auto ray = camera.unproject(pixel);
    if (!ray) continue;
    const auto back = camera.project(ray->homogeneous());
    ASSERT_TRUE(back);
    EXPECT_LT((*back - pixel).norm(), 1e-5);
  }
}

TEST(CameraFromFieldOfView, HasThatAngle) {
  const Camera camera = camera_from_field_of_view(90.0, 640, 480);
  EXPECT_NEAR(camera.fx, 320.0, 1e-12);
  const auto left = camera.unproject({-0.5, 239.5}), right = camera.unproject({639.5, 239.5});
  EXPECT_NEAR(std::atan(right->x()) - std::atan(left->x()), std::numbers::pi / 2.0, 1e-12);
  EXPECT_NEAR(left->y(), 0.0, 1e-15);
  EXPECT_TRUE(calibration_warnings(camera).empty());
}

}  // namespace
}  // namespace rastro
