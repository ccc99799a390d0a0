// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/live_messages.h"

#include <array>
#include <nlohmann/json.hpp>

#include "rastro/viewer/block_writer.h"
#include "rastro/viewer/feature_block.h"
#include "rastro/viewer/scene.h"

namespace rastro {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array all_commands = {LiveCommand::pause,      LiveCommand::resume,      LiveCommand::step,
                                     LiveCommand::mapping_on, LiveCommand::mapping_off, LiveCommand::reset,
                                     LiveCommand::save,       LiveCommand::end};

template <typename Value>
Json or_null(const std::optional<Value>& value) {
  return value ? Json(*value) : Json();
}

Json pose_json(const SE3& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond q = pose.rotation().quaternion();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

void put_image(const LiveImage& image, Json& header, detail::BlockBody& body) {
  header["index"] = image.index;
  header["width"] = image.width;
  header["height"] = image.height;
  header["jpeg"] = body.put(image.jpeg);
  detail::put_features(image.features, header, body);
}

void add_if_any(Json& json, const char* name, const std::string& text) {
  if (!text.empty()) json[name] = text;
}

}  // namespace

const char* name_of(LiveCommand command) {
  switch (command) {
    case LiveCommand::pause:
      return "pause";
    case LiveCommand::resume:
      return "resume";
    case LiveCommand::step:
      return "step";
    case LiveCommand::mapping_on:
      return "mapping_on";
    case LiveCommand::mapping_off:
      return "mapping_off";
    case LiveCommand::reset:
      return "reset";
    case LiveCommand::save:
      return "save";
    case LiveCommand::end:
      return "end";
  }
  return "unknown";
}

std::optional<LiveCommand> live_command_in(std::string_view message) {
  const auto json = nlohmann::json::parse(message, nullptr, false);
  if (!json.is_object() || json.size() != 1 || !json.contains("command") || !json["command"].is_string())
    return std::nullopt;
  const auto& name = json["command"].get_ref<const std::string&>();
  for (const LiveCommand command : all_commands)
    if (name == name_of(command)) return command;
  return std::nullopt;
}

std::string message_of(const LiveHello& hello) {
  Json json{{"type", "hello"}, {"version", 1}, {"title", hello.title}, {"method", hello.method}};
  json["state_names"] = hello.state_names.empty() ? scene_state_names() : hello.state_names;
  json["frames"] = or_null(hello.frames);
  json["commands"] = Json::array();
  for (const LiveCommand command : hello.commands) json["commands"].push_back(name_of(command));
  json["poses"] = hello.has_poses;
  return detail::text_of(json);
}

std::string message_of(const LiveFrame& frame) {
  Json json{{"type", "frame"}, {"index", frame.index}, {"stamp", frame.stamp_s}, {"state", frame.state}};
  add_if_any(json, "reason", frame.reason);
  add_if_any(json, "detail", frame.detail);
  add_if_any(json, "advice", frame.advice);
  json["pose"] = frame.world_from_body ? pose_json(*frame.world_from_body) : Json();
  json["sigma"] = or_null(frame.sigma);
  json["used"] = frame.used;
  json["score"] = frame.score;
  json["ms"] = frame.milliseconds;
  json["stages"] = Json::object();
  for (const auto& [stage, milliseconds] : frame.stages) json["stages"][stage] = milliseconds;
  json["events"] = Json::array();
  for (const auto& [kind, detail] : frame.events) json["events"].push_back({{"kind", kind}, {"detail", detail}});
  json["done"] = frame.done;
  json["rate"] = frame.rate_hz;
  json["memory_mb"] = frame.memory_mb;
  std::string text = detail::text_of(json);
  text.pop_back();
  return text;
}

std::string message_of(const LiveStatus& status) {
  Json json{{"type", "status"}, {"paused", status.paused}};
  json["mapping"] = or_null(status.mapping);
  json["ended"] = status.ended;
  json["line"] = status.line;
  json["resets"] = status.resets;
  return detail::text_of(json);
}

std::string message_of(const LiveCalibration& calibration) {
  Json json{{"type", "calibration"}, {"line", calibration.line}};
  json["views"] = calibration.views;
  json["enough_views"] = calibration.enough_views;
  json["enough"] = calibration.enough;
  json["wanted_tilt"] = calibration.wanted_tilt_deg;
  json["missing"] = calibration.missing;
  json["cameras"] = Json::array();
  for (const LiveCoverage& camera : calibration.cameras)
    json["cameras"].push_back(
        {{"name", camera.camera}, {"seen", camera.seen}, {"missing", camera.missing}, {"tilts", camera.tilts_deg}});
  json["outlines"] = calibration.outlines;
  return detail::text_of(json);
}

std::string scene_message(std::int64_t revision) {
  return detail::text_of({{"type", "scene"}, {"index", 0}, {"revision", revision}});
}

std::string block_of(const LiveImage& image) {
  detail::BlockBody body;
  Json header{{"type", "image"}};
  put_image(image, header, body);
  return detail::block_of(header, body);
}

std::string block_of(const LivePlace& place) {
  detail::BlockBody body;
  Json header{{"type", "place"}, {"keyframe", place.keyframe}};
  put_image(place.image, header, body);
  if (place.matched_image) {
    header["matched"] = {{"keyframe", place.matched}};
    put_image(*place.matched_image, header["matched"], body);
  }
  return detail::block_of(header, body);
}

}  // namespace rastro
