// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/benchmark_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/cli/benchmark/yaml_fields.h"
#include "rastro/synthetic/disturbance/disturbance.h"

namespace rastro::cli {
namespace {

const std::vector<std::string> list_keys = {"about", "entries", "false_pose_limit_m", "timeout_s", "keep", "tolerance"};
const std::vector<std::string> tolerance_keys = {"ate_percent", "ate_m",     "tracked_points", "time_percent",
                                                 "time_ms",     "memory_mb", "memory_percent"};
const std::vector<std::string> entry_keys = {"name",
                                             "data",
                                             "world",
                                             "seeds",
                                             "simulate",
                                             "frames",
                                             "command",
                                             "method",
                                             "sensor",
                                             "settings",
                                             "flags",
                                             "disturb",
                                             "map",
                                             "expect",
                                             "ground_truth",
                                             "alignment",
                                             "false_pose_limit_m"};
const std::vector<std::string> map_keys = {"data", "world", "simulate", "frames", "settings", "flags", "same_world"};

/// The value itself if it is one of `allowed`.
std::string choice_of(const YamlFields& fields, const char* key, const std::string& if_missing,
                      const std::vector<std::string>& allowed) {
  const std::string value = fields.text(key, if_missing);
  if (value != if_missing && std::find(allowed.begin(), allowed.end(), value) == allowed.end())
    fields.refuse(key, "is " + in_quotes(value), fmt::format("give {}", fmt::join(allowed, " or ")));
  return value;
}

BenchmarkInput input_of(const YamlFields& fields) {
  BenchmarkInput input;
  input.simulate = fields.words("simulate");
  input.frames = fields.text("frames");
  return input;
}

/// The variants that the lists of an entry stand for; a key that is not a list has one.
struct Variants {
  std::vector<std::string> inputs, methods, disturbances;
  bool worlds = false;
};

Variants variants_of(const YamlFields& fields) {
  Variants variants;
  variants.worlds = fields.has("world");
  if (variants.worlds == fields.has("data"))
    fields.refuse("data", variants.worlds ? "and 'world' are both given" : "and 'world' are missing",
                  "give one of them");
  variants.inputs = fields.texts(variants.worlds ? "world" : "data");
  variants.methods = fields.texts("method");
  if (variants.methods.empty()) fields.refuse("method", "is missing", "give one; 'rastro methods' lists them");
  variants.disturbances = fields.has("disturb") ? fields.texts("disturb") : std::vector<std::string>{"none"};
  return variants;
}

std::vector<std::string> disturbances_in(const YamlFields& fields, const std::string& text) {
  std::vector<std::string> all;
  for (const std::string_view piece : split(text, '+')) {
    const std::string each(piece);
    if (each == "none") continue;
    try {
      check_disturbance(each);
    } catch (const Error& error) {
      throw Error(fmt::format("{}: {}", fields.at(fields.node("disturb")), error.what()));
    }
    all.push_back(each);
  }
  return all;
}

BenchmarkMap map_of(const YamlFields& entry, const BenchmarkInput& input, const std::string& file) {
  const YamlFields fields(entry.node("map"), file, map_keys);
  BenchmarkMap map;
  map.input = input_of(fields);
  map.settings = fields.assignments("settings");
  if (fields.has("data") && fields.has("world"))
    fields.refuse("data", "and 'world' are both given", "give one of them");
  map.input.data = fields.text("data");
  map.input.world = fields.text("world");
  if (map.input.data.empty() && map.input.world.empty()) map.input.data = input.data, map.input.world = input.world;
  if (!fields.has("simulate") && map.input.world == input.world) map.input.simulate = input.simulate;
  const bool same = map.input.data == input.data && map.input.world == input.world;
  map.same_world = fields.flag("same_world", same);
  map.flags = fields.has("flags") || !same ? fields.words("flags") : entry.words("flags");
  return map;
}

std::string described(const BenchmarkInput& input) {
  std::string text = input.data.empty() ? input.world : input.data;
  return input.frames.empty() ? text : text + "@" + input.frames;
}

std::string name_of(const BenchmarkEntry& entry, const YamlFields& fields) {
  std::vector<std::string> parts = {fields.text("name")};
  const bool named = !parts.front().empty();
  if (!named) parts.front() = described(entry.input);
  if (named && fields.texts(entry.input.data.empty() ? "world" : "data").size() > 1)
    parts.push_back(described(entry.input));
  if (!named && entry.map) parts.push_back("in " + described(entry.map->input));
  if (!named && entry.method.command == "odometry") parts.emplace_back("odometry");
  if (!named || fields.texts("method").size() > 1) parts.push_back(entry.method.method);
  if (!named && !entry.method.sensor.empty()) parts.push_back(entry.method.sensor);
  if (!entry.disturbances.empty()) parts.push_back(fmt::format("{}", fmt::join(entry.disturbances, "+")));
  return one_line(fmt::format("{}", fmt::join(parts, " ")), 100);
}

/// What all variants of an entry have in common.
BenchmarkEntry common_of(const YamlFields& fields, double limit_m) {
  BenchmarkEntry entry;
  entry.input = input_of(fields);
  entry.method.command = choice_of(fields, "command", "slam", {"slam", "odometry"});
  entry.method.sensor = fields.text("sensor");
  entry.method.settings = fields.assignments("settings");
  entry.method.flags = fields.words("flags");
  const std::string expect = choice_of(fields, "expect", "", {"found", "lost"});
  entry.expect = expect == "found" ? Expectation::found : expect == "lost" ? Expectation::lost : Expectation::none;
  entry.ground_truth = fields.text("ground_truth");
  entry.alignment = choice_of(fields, "alignment", "", {"se3", "sim3", "yaw"});
  entry.false_pose_limit_m = fields.number("false_pose_limit_m", limit_m, 0.0);
  entry.seeds = fields.numbers("seeds");
  if (fields.has("seeds") && !fields.has("world")) fields.refuse("seeds", "is for worlds", "omit it");
  if (fields.has("world") && entry.seeds.empty()) entry.seeds = {1};
  if (fields.has("map") && entry.method.command != "slam")
    fields.refuse("command", "is for runs without a map", "omit it: with 'map' a run is 'rastro localize'");
  if (!expect.empty() && !fields.has("map")) fields.refuse("expect", "is for runs with a map", "omit it");
  return entry;
}

void add_entries(const YAML::Node& node, double limit_m, BenchmarkList& list) {
  const YamlFields fields(node, list.file, entry_keys);
  const BenchmarkEntry common = common_of(fields, limit_m);
  const Variants variants = variants_of(fields);
  for (const std::string& input : variants.inputs) {
    for (const std::string& method : variants.methods) {
      for (const std::string& disturbance : variants.disturbances) {
        BenchmarkEntry entry = common;
        (variants.worlds ? entry.input.world : entry.input.data) = input;
        entry.method.method = method;
        entry.disturbances = disturbances_in(fields, disturbance);
        if (fields.has("map")) entry.map = map_of(fields, entry.input, list.file);
        entry.name = name_of(entry, fields);
        const auto same = [&](const BenchmarkEntry& other) { return other.name == entry.name; };
        if (std::any_of(list.entries.begin(), list.entries.end(), same))
          throw Error("two entries are called " + in_quotes(entry.name), fields.at(node), "give one another 'name'");
        list.entries.push_back(std::move(entry));
      }
    }
  }
}

BenchmarkTolerance tolerance_of(const YamlFields& list, const std::string& file) {
  BenchmarkTolerance tolerance;
  if (!list.has("tolerance")) return tolerance;
  const YamlFields fields(list.node("tolerance"), file, tolerance_keys);
  for (auto& [key, value] : std::map<const char*, double*>{{"ate_percent", &tolerance.ate_percent},
                                                           {"ate_m", &tolerance.ate_m},
                                                           {"tracked_points", &tolerance.tracked_points},
                                                           {"time_percent", &tolerance.time_percent},
                                                           {"time_ms", &tolerance.time_ms},
                                                           {"memory_percent", &tolerance.memory_percent},
                                                           {"memory_mb", &tolerance.memory_mb}})
    *value = fields.number(key, *value, 0.0);
  return tolerance;
}

}  // namespace

BenchmarkList parse_benchmark_list(const std::string& yaml, const std::string& file) {
  BenchmarkList list;
  list.file = file;
  const YamlFields fields(parse_yaml(yaml, file), file, list_keys);
  const YAML::Node entries = fields.node("entries");
  if (!entries.IsDefined() || !entries.IsSequence() || entries.size() == 0)
    fields.refuse("entries", "is not a list of entries", "give at least one, beginning with '- '");
  list.timeout_s = fields.number("timeout_s", list.timeout_s, 1.0);
  list.keep = fields.flag("keep", list.keep);
  list.tolerance = tolerance_of(fields, file);
  const double limit_m = fields.number("false_pose_limit_m", BenchmarkEntry().false_pose_limit_m, 0.0);
  for (const YAML::Node& entry : entries) add_entries(entry, limit_m, list);
  return list;
}

BenchmarkList read_benchmark_list(const std::string& file) { return parse_benchmark_list(read_text_file(file), file); }

}  // namespace rastro::cli
