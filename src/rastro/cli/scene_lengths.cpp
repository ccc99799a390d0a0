// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/scene_lengths.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/evaluate/map_lengths.h"
#include "rastro/map/images/image_layer.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

constexpr const char* result_file = "lengths.json";
constexpr double largest_m = 1e6;

/// The line in the middle between both ends, along the direction of the measurement.
SceneLength line_of(const std::string& name, double length, double sigma, const Vector3d& a, const Vector3d& b,
                    const Vector3d& direction) {
  SceneLength line{one_line(name), {a.x(), a.y(), a.z()}, {b.x(), b.y(), b.z()}, length, sigma};
  if (direction.norm() < 0.5) return line;
  const Vector3d middle = 0.5 * (a + b), half = 0.5 * length * direction.normalized();
  for (int axis = 0; axis < 3; ++axis) {
    line.a[static_cast<std::size_t>(axis)] = middle[axis] - half[axis];
    line.b[static_cast<std::size_t>(axis)] = middle[axis] + half[axis];
  }
  return line;
}

SceneLength line_of(const MeasuredLength& one) {
  return line_of(one.name, *one.length_m, one.sigma_m, one.a, one.b, one.direction);
}

std::optional<double> number_of(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number()) return std::nullopt;
  const double number = found->get<double>();
  return std::abs(number) < largest_m ? std::optional(number) : std::nullopt;
}

std::optional<Vector3d> vector_of(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array() || found->size() != 3) return std::nullopt;
  Vector3d vector;
  for (int axis = 0; axis < 3; ++axis) {
    const Json& one = (*found)[static_cast<std::size_t>(axis)];
    if (!one.is_number() || !(std::abs(one.get<double>()) < largest_m)) return std::nullopt;
    vector[axis] = one.get<double>();
  }
  return vector;
}

[[noreturn]] void refuse_result(const std::string& file) {
  throw Error("is no result of 'rastro measure'", file, "write it anew with --json, or remove it");
}

/// Of the only map of the file.
std::vector<SceneLength> lengths_in_result(const std::string& file) {
  const Json json = Json::parse(read_text_file(file), nullptr, false);
  if (!json.is_object() || !json.contains("maps") || !json["maps"].is_array()) refuse_result(file);
  if (json["maps"].size() != 1) throw Error("has the lengths of several maps", file, "measure in the map of this run");
  const Json& map = json["maps"][0];
  if (!map.is_object() || !map.contains("lengths") || !map["lengths"].is_array()) refuse_result(file);
  std::vector<SceneLength> lengths;
  for (const Json& one : map["lengths"]) {
    if (!one.is_object() || !one.contains("name") || !one["name"].is_string()) refuse_result(file);
    const auto length = number_of(one, "length_m");
    const auto a = vector_of(one, "a"), b = vector_of(one, "b");
    if (!length) continue;  // it could not be measured
    if (!a || !b) refuse_result(file);
    lengths.push_back(line_of(one["name"], *length, number_of(one, "sigma_m").value_or(0.0), *a, *b,
                              vector_of(one, "direction").value_or(Vector3d::Zero())));
  }
  return lengths;
}

std::vector<SceneLength> measured_lengths(const ExportInput& input, const std::string& file, TaskPool& pool) {
  const LengthObjects wanted = parse_length_objects(read_text_file(file), file);
  if (wanted.in_frame_of_ground_truth)
    throw Error("gives its points in the frame of the ground truth", file,
                "'rastro measure RUN --align FILE --json > RUN/lengths.json' measures them for the page");
  need_layer<ImageLayer>(input, "a length");
  std::vector<SceneLength> lengths;
  for (const MeasuredLength& one : measure_lengths(*input.map, wanted.objects, {}, pool)) {
    if (one.length_m)
      lengths.push_back(line_of(one));
    else
      log_warning(fmt::format("{} was not measured: {}", in_quotes(one.name), one.note));
  }
  return lengths;
}

/// The values of a query by their names, with the commas that browsers encode.
std::string value_in(std::string_view query, std::string_view name) {
  for (const std::string_view part : split(query, '&')) {
    if (part.size() <= name.size() || !part.starts_with(name) || part[name.size()] != '=') continue;
    std::string value(part.substr(name.size() + 1));
    for (std::size_t at = value.find('%'); at != std::string::npos; at = value.find('%', at + 1))
      if (value.compare(at, 3, "%2C") == 0) value.replace(at, 3, ",");
    return value;
  }
  return {};
}

std::optional<Vector3d> vector_in(std::string_view query, const std::string& name) {
  const std::string text = value_in(query, name);
  const auto pieces = split(text, ',');
  if (pieces.size() != 3) return std::nullopt;
  Vector3d vector;
  for (int axis = 0; axis < 3; ++axis) {
    const auto number = parse_finite(pieces[static_cast<std::size_t>(axis)]);
    if (!number || !(std::abs(*number) < largest_m)) return std::nullopt;
    vector[axis] = *number;
  }
  return vector;
}

std::optional<LengthPoint> end_in(std::string_view query, const std::string& name, LengthKind kind) {
  const auto point = vector_in(query, name), direction = vector_in(query, name + "_direction");
  if (!point || !direction || !(direction->norm() > 1e-3)) return std::nullopt;
  LengthPoint end;
  end.point = *point;
  if (kind == LengthKind::planes) end.normal = direction->normalized();
  if (kind == LengthKind::edges) {
    end.directions = {direction->normalized()};
    end.face = vector_in(query, name + "_face");
  }
  return end;
}

std::optional<LengthObject> object_in(std::string_view query) {
  LengthObject object;
  const std::string kind = value_in(query, "kind");
  if (kind != "edges" && kind != "planes") return std::nullopt;
  object.name = "clicked";
  object.kind = kind == "edges" ? LengthKind::edges : LengthKind::planes;
  const auto a = end_in(query, "a", object.kind), b = end_in(query, "b", object.kind);
  if (!a || !b || (a->point - b->point).norm() < 1e-3) return std::nullopt;
  object.a = *a;
  object.b = *b;
  return object;
}

Json as_json(const MeasuredLength& one) {
  if (!one.length_m) return {{"problem", one.note}};
  const SceneLength line = line_of(one);
  return {{"length", line.length}, {"sigma", line.sigma}, {"a", line.a}, {"b", line.b}, {"note", one.note}};
}

}  // namespace

std::vector<SceneLength> lengths_of(const ExportInput& input, const std::string& objects, TaskPool& pool) {
  std::vector<SceneLength> lengths;
  if (!objects.empty()) lengths = measured_lengths(input, objects, pool);
  std::error_code ignored;
  const fs::path file = fs::path(input.path) / result_file;
  if (!fs::is_regular_file(file, ignored)) return lengths;
  for (SceneLength& one : lengths_in_result(file.string())) lengths.push_back(std::move(one));
  return lengths;
}

std::string measured_as_json(const Map& map, std::string_view query, TaskPool& pool) {
  const auto object = object_in(query);
  if (!object) return Json{{"problem", "this is no length"}}.dump();
  try {
    return as_json(measure_lengths(map, {*object}, {}, pool).front()).dump();
  } catch (const Error& error) {  // the images may have gone in the meantime
    return Json{{"problem", one_line(error.what())}}.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
}

std::function<std::string(std::string_view)> measuring_in(const ExportInput& input, int threads) {
  if (!input.map || !input.map->layer<ImageLayer>()) return {};
  return [map = input.map, pool = std::make_shared<TaskPool>(threads)](std::string_view query) {
    return measured_as_json(*map, query, *pool);
  };
}

}  // namespace rastro::cli
