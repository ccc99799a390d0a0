// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/occluder/outline.h"

#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

using Eigen::Vector2d;

/// Distance to a rod from a to b whose radius changes from radius_a to radius_b.
double rod(const Vector2d& position, const Vector2d& a, const Vector2d& b, double radius_a, double radius_b) {
  const Vector2d along = b - a;
  const double part = std::clamp((position - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (position - a - part * along).norm() - (radius_a + part * (radius_b - radius_a));
}

/// Distance to an ellipse, valid near the outline, which suffices for soft edges.
double ellipse(const Vector2d& position, const Vector2d& center, const Vector2d& radii) {
  const Vector2d unit = (position - center).cwiseQuotient(radii);
  return (unit.norm() - 1.0) * radii.minCoeff();
}

void join(OutlineDistance& whole, double distance, OccluderPart part) {
  if (distance < whole.distance) whole = {distance, part};
}

OutlineDistance figure_distance(const Vector2d& position, double sway) {
  const Vector2d mirrored(std::abs(position.x()), position.y());
  const double side = position.x() < 0 ? -1.0 : 1.0;
  OutlineDistance whole{rod(position, {0, 0.50}, {0, 0.68}, 0.10, 0.12), OccluderPart::skin};
  join(whole, ellipse(position, {0, 0.30}, {0.17, 0.23}), OccluderPart::skin);
  join(whole, ellipse(position, {0, 0.21}, {0.185, 0.17}), OccluderPart::hair);
  join(whole, rod(mirrored, {0.14, 0.76}, {0.33, 0.82}, 0.13, 0.11), OccluderPart::shirt);
  join(whole, rod(position, {0, 0.85}, {0, 1.75}, 0.36, 0.28), OccluderPart::shirt);
  const Vector2d elbow(0.44, 1.28), hand(0.42 + 0.07 * sway * side, 1.74);
  join(whole, rod(mirrored, {0.37, 0.84}, elbow, 0.10, 0.085), OccluderPart::shirt);
  join(whole, rod(mirrored, elbow, hand, 0.085, 0.06), OccluderPart::shirt);
  join(whole, ellipse(mirrored, hand + Vector2d(0, 0.08), {0.07, 0.10}), OccluderPart::skin);
  const Vector2d knee(0.18 + 0.10 * sway * side, 2.45), foot(0.20 - 0.14 * sway * side, 3.25);
  join(whole, rod(mirrored, {0.15, 1.78}, knee, 0.17, 0.12), OccluderPart::trousers);
  join(whole, rod(mirrored, knee, foot, 0.12, 0.09), OccluderPart::trousers);
  return whole;
}

}  // namespace

OutlineDistance outline_distance(OccluderShape shape, const Vector2d& position, double sway) {
  if (shape == OccluderShape::post) return {std::abs(position.x()) - 0.5, OccluderPart::post};
  return figure_distance(position, sway);
}

}  // namespace rastro
