// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_objects.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <initializer_list>
#include <set>
#include <string>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

constexpr const char* form = "see 'rastro measure --help' for the form of the file";
constexpr double farthest_m = 1e4, smallest_radius_m = 0.005, largest_radius_m = 0.5;
constexpr double nearest_face_m = 0.002;
constexpr std::size_t most_objects = 1000;

/// A part of the file with 'key: value' lines; any fault is reported in one line with file, line and key.
class SpotFields {
 public:
  SpotFields(YAML::Node node, std::string where, std::initializer_list<const char*> keys)
      : node_(std::move(node)), where_(std::move(where)) {
    const std::vector<std::string> known(keys.begin(), keys.end());
    if (!node_.IsMap()) throw Error("is not 'key: value' lines", at(node_), form);
    for (const auto& entry : node_) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      throw Error(fmt::format("unknown key {}", in_quotes(key)), at(entry.first), did_you_mean(key, known));
    }
  }

  bool has(const char* key) const { return static_cast<bool>(node_[key]); }

  YAML::Node part(const char* key) const {
    if (!has(key)) throw Error(fmt::format("no key '{}'", key), at(node_), form);
    return node_[key];
  }

  std::string text(const char* key) const {
    const YAML::Node value = part(key);
    if (!value.IsScalar() || value.Scalar().empty()) refuse(value, key, "is not a single word");
    return one_line(value.Scalar(), 100);
  }

  double number(const char* key, double low, double high) const {
    const auto value = parse_finite(text(key));
    if (!value || !(*value >= low && *value <= high))
      refuse(part(key), key, fmt::format("is not a number from {} to {}", low, high));
    return *value;
  }

  Vector3d vector(const char* key) const { return vector_in(part(key), key); }
  Vector3d direction(const char* key) const { return direction_in(part(key), key); }

  std::vector<Vector3d> directions(const char* key) const {
    const YAML::Node list = part(key);
    if (!list.IsSequence() || list.size() != 2) refuse(list, key, "is not two directions");
    std::vector<Vector3d> both = {direction_in(list[0], key), direction_in(list[1], key)};
    if (both[0].cross(both[1]).norm() < 0.2) refuse(list, key, "are two nearly parallel directions");
    return both;
  }

  [[noreturn]] void refuse(const YAML::Node& value, const char* key, const std::string& what) const {
    throw Error(fmt::format("{} {}", key, what), at(value), form);
  }

  std::string at(const YAML::Node& value) const { return at_line(where_, value.Mark().line + 1); }

 private:
  Vector3d vector_in(const YAML::Node& list, const char* key) const {
    if (!list.IsSequence() || list.size() != 3) refuse(list, key, "is not three numbers [x, y, z]");
    Vector3d numbers;
    for (int k = 0; k < 3; ++k) {
      const YAML::Node entry = list[k];
      const auto number = parse_finite(entry.IsScalar() ? entry.Scalar() : "?");
      if (!number || std::abs(*number) > farthest_m) refuse(list, key, "is not three plausible numbers [x, y, z]");
      numbers[k] = *number;
    }
    return numbers;
  }

  Vector3d direction_in(const YAML::Node& list, const char* key) const {
    const Vector3d direction = vector_in(list, key);
    if (direction.norm() < 1e-6) refuse(list, key, "is not a direction");
    return direction.normalized();
  }

  YAML::Node node_;
  std::string where_;
};

LengthKind kind_in(const SpotFields& fields) {
  const std::string text = fields.text("kind");
  for (const LengthKind kind : {LengthKind::edges, LengthKind::planes, LengthKind::points})
    if (text == name_of(kind)) return kind;
  fields.refuse(fields.part("kind"), "kind", "is not one of edges, planes, points");
}

LengthPoint spot_in(const YAML::Node& node, const std::string& where, LengthKind kind) {
  const SpotFields fields = kind == LengthKind::edges    ? SpotFields(node, where, {"point", "direction", "face"})
                            : kind == LengthKind::planes ? SpotFields(node, where, {"point", "normal"})
                                                         : SpotFields(node, where, {"point", "edges", "face"});
  LengthPoint spot;
  spot.point = fields.vector("point");
  if (kind == LengthKind::edges) spot.directions = {fields.direction("direction")};
  if (kind == LengthKind::points && fields.has("edges")) spot.directions = fields.directions("edges");
  if (fields.has("normal")) spot.normal = fields.direction("normal");
  if (fields.has("face")) spot.face = fields.vector("face");
  return spot;
}

/// The face point must be beside each edge: it tells on which side the face is.
void check_faces(const LengthObject& object, const SpotFields& fields) {
  for (const LengthPoint* spot : {&object.a, &object.b}) {
    const char* key = spot == &object.a ? "a" : "b";
    const Vector3d inwards = spot->face.value_or(0.5 * (object.a.point + object.b.point)) - spot->point;
    for (const Vector3d& direction : spot->directions) {
      if (inwards.cross(direction).norm() < nearest_face_m)
        fields.refuse(fields.part(key), key, "has its face point on the line of the edge itself");
    }
  }
}

LengthObject object_in(const YAML::Node& node, const std::string& where, double default_radius_m) {
  const SpotFields fields(node, where, {"name", "length_m", "kind", "radius_m", "a", "b"});
  LengthObject object;
  object.name = fields.text("name");
  object.kind = kind_in(fields);
  object.radius_m = default_radius_m;
  if (fields.has("length_m")) object.true_length_m = fields.number("length_m", 1e-4, farthest_m);
  if (fields.has("radius_m")) object.radius_m = fields.number("radius_m", smallest_radius_m, largest_radius_m);
  object.a = spot_in(fields.part("a"), where, object.kind);
  object.b = spot_in(fields.part("b"), where, object.kind);
  if ((object.a.point - object.b.point).norm() < 1e-3)
    fields.refuse(fields.part("b"), "b", "is at the same position as a");
  if (object.kind == LengthKind::edges && std::abs(object.a.directions[0].dot(object.b.directions[0])) < 0.8)
    fields.refuse(fields.part("b"), "b", "has an edge that is not parallel to that of a");
  check_faces(object, fields);
  return object;
}

YAML::Node loaded(std::string_view yaml, std::string_view where) {
  try {
    return YAML::Load(std::string(yaml));
  } catch (const YAML::Exception& error) {
    throw Error(fmt::format("not valid YAML: {}", one_line(error.msg)), at_line(where, error.mark.line + 1), form);
  }
}

void move_spot(LengthPoint& spot, const SE3& target_from_source) {
  spot.point = target_from_source * spot.point;
  for (Vector3d& direction : spot.directions) direction = target_from_source.rotation() * direction;
  if (spot.normal) spot.normal = target_from_source.rotation() * *spot.normal;
  if (spot.face) spot.face = target_from_source * *spot.face;
}

}  // namespace

const char* name_of(LengthKind kind) {
  switch (kind) {
    case LengthKind::edges:
      return "edges";
    case LengthKind::planes:
      return "planes";
    case LengthKind::points:
      break;
  }
  return "points";
}

LengthObjects parse_length_objects(std::string_view yaml, std::string_view where) {
  const std::string file(where);
  const SpotFields fields(loaded(yaml, where), file, {"frame", "radius_m", "objects"});
  LengthObjects read;
  if (fields.has("frame")) {
    const std::string frame = fields.text("frame");
    read.in_frame_of_ground_truth = frame == "truth";
    if (!read.in_frame_of_ground_truth && frame != "first_camera")
      fields.refuse(fields.part("frame"), "frame", "is neither first_camera nor truth");
  }
  const double radius_m =
      fields.has("radius_m") ? fields.number("radius_m", smallest_radius_m, largest_radius_m) : LengthObject().radius_m;
  const YAML::Node list = fields.part("objects");
  if (!list.IsSequence() || list.size() == 0 || list.size() > most_objects)
    fields.refuse(list, "objects", fmt::format("is not a list of 1 to {} objects", most_objects));
  std::set<std::string> names;
  for (const YAML::Node& node : list) {
    read.objects.push_back(object_in(node, file, radius_m));
    if (!names.insert(read.objects.back().name).second)
      fields.refuse(node, "name", fmt::format("{} is that of two objects", in_quotes(read.objects.back().name)));
  }
  return read;
}

LengthObject moved(const LengthObject& object, const SE3& target_from_source) {
  LengthObject result = object;
  move_spot(result.a, target_from_source);
  move_spot(result.b, target_from_source);
  return result;
}

}  // namespace rastro
