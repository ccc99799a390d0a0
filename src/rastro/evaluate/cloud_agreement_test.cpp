// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/cloud_agreement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/random.h"

namespace rastro {
namespace {

/// A square of 2 m in z = 0, of two triangles.
TriangleMesh square() {
  TriangleMesh mesh;
  for (const Eigen::Vector3f& corner :
       {Eigen::Vector3f(-1, -1, 0), Eigen::Vector3f(1, -1, 0), Eigen::Vector3f(1, 1, 0), Eigen::Vector3f(-1, 1, 0)})
    mesh.vertices.push_back({corner, {0, 0, 1}, {}});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

CloudPoint point_at(const Eigen::Vector3f& position, float sigma) {
  CloudPoint point;
  point.position = position;
  point.sigma = sigma;
  return point;
}

/// Points on the part x < `until` of the square with noise of 5 mm.
PointCloud noisy(float until) {
  PointCloud cloud;
  Random random(2);
  for (int k = 0; k < 40000; ++k) {
    CloudPoint point;
    point.position =
        Eigen::Vector3d(random.uniform(-1, until), random.uniform(-1, 1), 0.005 * random.normal()).cast<float>();
    point.sigma = 0.005F;
    cloud.points.push_back(point);
  }
  return cloud;
}

TEST(CloudAgreement, GivesTheNoiseOfPointsAndTheCoveredShareOfTheSurface) {
  const CloudAgreement agreement = cloud_agreement(square(), noisy(0.0F), {});
  EXPECT_EQ(agreement.points, 40000U);
  EXPECT_NEAR(agreement.rms, 0.005, 2e-4);
  EXPECT_NEAR(agreement.mean, 0.005 * std::sqrt(2.0 / M_PI), 2e-4);
  EXPECT_NEAR(agreement.median, 0.005 * 0.6745, 2e-4);
  EXPECT_NEAR(agreement.percentile_95, 0.005 * 1.96, 4e-4);
  EXPECT_NEAR(agreement.sigma_ratio, 1.0, 0.03);
  EXPECT_GT(agreement.precision, 0.999);
  EXPECT_NEAR(agreement.completeness, 0.5 * (1.0 + 0.02), 0.01) << "half of it, and a rim as wide as the tolerance";
}

TEST(CloudAgreement, MeasuresExactlyToTrianglesAndTheirRims) {
  PointCloud cloud;
  for (const Eigen::Vector3f& position : {Eigen::Vector3f(0.3037F, -0.777F, 0.25F), Eigen::Vector3f(1.3F, 0.123F, 0.4F),
                                          Eigen::Vector3f(-1.3F, -1.4F, 0.0F)})
    cloud.points.push_back(point_at(position, 0.0F));
  const CloudAgreement agreement = cloud_agreement(square(), cloud, {});
  EXPECT_NEAR(agreement.mean, (0.25 + 0.5 + 0.5) / 3.0, 1e-6);
  EXPECT_TRUE(std::isnan(agreement.sigma_ratio)) << "points without sigma do not count";
}

TEST(CloudAgreement, ComparesWithPointsWhereThereAreNoTrianglesForAnyPool) {
  TriangleMesh points = square();
  points.triangles.clear();
  PointCloud cloud;
  cloud.points.push_back(point_at({1.0F, 1.0F, 0.1F}, 0.1F));
  const CloudAgreement agreement = cloud_agreement(points, cloud, {});
  EXPECT_NEAR(agreement.largest, 0.1, 1e-6);
  TaskPool pool(8);
  const CloudAgreement alone = cloud_agreement(square(), noisy(1.0F), {});
  const CloudAgreement together = cloud_agreement(square(), noisy(1.0F), {}, &pool);
  EXPECT_EQ(alone.mean, together.mean);
  EXPECT_EQ(alone.completeness, together.completeness);
  EXPECT_THROW(cloud_agreement(TriangleMesh(), cloud, {}), Error);
  EXPECT_THROW(cloud_agreement(square(), PointCloud(), {}), Error);
}

}  // namespace
}  // namespace rastro
