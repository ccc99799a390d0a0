// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_feature.h"

#include <algorithm>

#include "rastro/base/error.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

LengthFeature edge_feature(const Vector3d& spot, const Vector3d& direction, const Vector3d& face) {
  LengthFeature feature{spot, direction, face - spot, true, true, 0.0};
  feature.inwards -= feature.inwards.dot(direction) * direction;
  feature.reach_m = feature.inwards.norm();
  RASTRO_CHECK(feature.reach_m > 0.0, "an edge with a face beside it");
  feature.inwards.normalize();
  return feature;
}

LengthFeature face_feature(const Vector3d& spot, const std::optional<Vector3d>& normal) {
  const Vector3d axis = normal.value_or(Vector3d::UnitZ());
  const Vector3d along = axis.unitOrthogonal();
  return {spot, along, axis.cross(along), false, normal.has_value(), 0.0};
}

}  // namespace

std::vector<LengthFeature> length_features(const LengthObject& object, const LengthPoint& spot,
                                           const MapLengthOptions& options) {
  const Vector3d face = spot.face.value_or(0.5 * (object.a.point + object.b.point));
  std::vector<LengthFeature> features;
  for (const Vector3d& direction : spot.directions) {
    Vector3d beside = Vector3d::Zero();
    if (spot.directions.size() > 1) {  // the edges of a corner end there: they are used where the face is
      const double ahead = direction.dot(face - spot.point);
      beside = std::clamp(ahead, -options.half_length_m, options.half_length_m) * direction;
    }
    features.push_back(edge_feature(spot.point + beside, direction, face));
  }
  if (features.empty()) features.push_back(face_feature(spot.point, spot.normal));
  return features;
}

LengthRegion length_region(const LengthFeature& feature, double radius_m, const MapLengthOptions& options) {
  LengthRegion region;
  region.center = feature.spot;
  region.axes << feature.along, feature.inwards, feature.normal();
  region.normal_known = feature.normal_known;
  if (!feature.is_edge) {
    // A point without a normal may be on something small: only its close surroundings are used.
    const double half = (feature.normal_known ? 0.5 : 0.25) * options.patch_m;
    const double deep = feature.normal_known ? radius_m : half;
    region.low = {-half, -half, -deep};
    region.high = {half, half, deep};
    return region;
  }
  // A narrow board ends soon behind its edge; a bed continues, but its middle adds no information.
  const double reach = std::max(radius_m, std::min(2.0 * feature.reach_m, options.patch_m));
  region.low = {-options.half_length_m, -0.5 * radius_m, -radius_m};
  region.high = {options.half_length_m, reach, radius_m};
  return region;
}

MeasuredLength not_measured(const LengthObject& object, const std::string& why) {
  MeasuredLength measured;
  measured.name = object.name;
  measured.kind = object.kind;
  measured.true_length_m = object.true_length_m;
  measured.a = object.a.point;
  measured.b = object.b.point;
  measured.note = why;
  return measured;
}

}  // namespace rastro
