// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/lengths_scale.h"

#include <algorithm>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/evaluate/length_scale.h"
#include "rastro/map/landmarks/map_scale.h"

namespace rastro::cli {
namespace {

/// As scaled() does with the map.
void scale_points(LengthObject& object, const Eigen::Vector3d& fixed, double factor) {
  const auto move = [&](Eigen::Vector3d& point) { point = fixed + factor * (point - fixed); };
  for (LengthPoint* end : {&object.a, &object.b}) {
    move(end->point);
    if (end->face) move(*end->face);
  }
}

}  // namespace

std::tuple<std::shared_ptr<const Map>, std::vector<LengthObject>> roughly_metric(std::shared_ptr<const Map> map,
                                                                                 std::vector<LengthObject> objects,
                                                                                 const std::string& known,
                                                                                 const std::string& where) {
  if (scale_of(*map).metric) return {std::move(map), std::move(objects)};
  const auto object =
      std::find_if(objects.begin(), objects.end(), [&](const LengthObject& one) { return one.name == known; });
  if (object == objects.end())
    throw Error("the scale of the map is arbitrary", where,
                "name a known length with --known, or make the map metric with 'rastro scale'");
  MapScaleFound rough;
  rough.meters_per_unit = *object->true_length_m / (object->a.point - object->b.point).norm();
  rough.from = "a known length";
  for (LengthObject& one : objects) scale_points(one, fixed_point_of(*map), rough.meters_per_unit);
  return {std::make_shared<const Map>(scaled(*map, rough)), std::move(objects)};
}

void apply_known_length(std::vector<MeasuredLength>& lengths, const std::string& known) {
  if (known.empty() || scale_by_known_length(lengths, known)) return;
  const auto one = std::find_if(lengths.begin(), lengths.end(), [&](const auto& other) { return other.name == known; });
  const std::string why = one->note;
  lengths.erase(one);
  for (MeasuredLength& other : lengths) {
    other.length_m.reset();
    other.note = in_quotes(known) + ", which sets the scale, is not measurable: " + why;
  }
}

}  // namespace rastro::cli
