// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/compare_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string_view>

namespace rastro::cli {
namespace {

std::string described(const BenchmarkInput& input) {
  std::string name = input.world.empty() ? input.data : input.world;
  if (!input.frames.empty()) name += "@" + input.frames;
  return name;
}

/// Short: what distinguishes the inputs of most lists.
std::string name_of(const BenchmarkEntry& entry) {
  std::string name = described(entry.input);
  if (entry.map) name += " in " + described(entry.map->input);
  if (!entry.disturbances.empty()) name += fmt::format(" {}", fmt::join(entry.disturbances, "+"));
  return name;
}

/// Everything that entries of one input have in common.
std::string key_of(const BenchmarkEntry& entry) {
  std::string key =
      fmt::format("{} {} seeds {}", name_of(entry), fmt::join(entry.input.simulate, " "), fmt::join(entry.seeds, ","));
  if (entry.map) key += fmt::format(" map {}", fmt::join(entry.map->input.simulate, " "));
  return key;
}

/// The first way to run it; one with a sensor where the method has a choice.
MethodOffer first_offer(const BenchmarkMethod& method) {
  return methods_named({method.command + "/" + method.method}).front();
}

/// That the entry says, in whatever way; empty: none, or the choice of the method.
std::string said_sensor(const BenchmarkMethod& method) {
  constexpr std::string_view setting = "sensor=";
  std::string sensor = method.sensor;
  for (const std::string& each : method.settings)
    if (each.starts_with(setting)) sensor = each.substr(setting.size());
  const auto flag = std::find(method.flags.begin(), method.flags.end(), "--sensor");
  if (flag != method.flags.end() && flag + 1 != method.flags.end()) sensor = *(flag + 1);
  return sensor == "auto" ? "" : sensor;
}

/// What a method that has the choice takes.
std::string sensor_taken(const InputFacts& facts) {
  if (facts.has_depth) return "rgbd";
  return facts.has_right ? "stereo" : "mono";
}

MethodOffer offer_with(MethodOffer offer, const std::string& sensor) {
  offer.sensor = sensor;
  if (!sensor.empty()) offer.kind = sensor == "rgbd" ? "depth" : sensor;
  return offer;
}

std::string column_of(const BenchmarkEntry& entry, const MethodOffer& offer) {
  std::string column = offer.name();
  if (!entry.method.settings.empty()) column += fmt::format(" {}", fmt::join(entry.method.settings, " "));
  return column;
}

CompareInput input_of(const BenchmarkEntry& entry, std::string name) {
  CompareInput input;
  input.name = std::move(name);
  input.input = entry.input;
  input.flags = entry.method.flags;
  input.seeds = entry.seeds;
  input.is_special = entry.map.has_value() || !entry.disturbances.empty();
  return input;
}

/// Two alike on one input have the names of their entries.
void name_columns(const BenchmarkList& list, std::vector<ListedCell>& cells) {
  for (std::size_t k = 0; k < cells.size(); ++k) {
    ListedCell& cell = cells[k];
    cell.column = column_of(list.entries[k], cell.method);
    const auto same = [&](const ListedCell& other) { return other.input == cell.input && other.column == cell.column; };
    const auto end = cells.begin() + static_cast<std::ptrdiff_t>(k);
    if (std::any_of(cells.begin(), end, same)) cell.column = list.entries[k].name;
  }
}

}  // namespace

ListedCells cells_of(const BenchmarkList& list) {
  ListedCells all;
  std::map<std::string, std::size_t> inputs;
  std::map<std::string, int> names;
  for (const BenchmarkEntry& entry : list.entries) {
    const auto [known, is_new] = inputs.emplace(key_of(entry), all.inputs.size());
    if (is_new) {
      const int count = ++names[name_of(entry)];
      all.inputs.push_back(
          input_of(entry, count == 1 ? name_of(entry) : fmt::format("{} ({})", name_of(entry), count)));
    }
    all.cells.push_back({known->second, offer_with(first_offer(entry.method), said_sensor(entry.method)), ""});
  }
  name_columns(list, all.cells);
  return all;
}

void choose_sensors(const BenchmarkList& list, const std::vector<CompareInput>& inputs, ListedCells& cells) {
  for (std::size_t k = 0; k < list.entries.size(); ++k) {
    ListedCell& cell = cells.cells[k];
    const bool has_choice = !first_offer(list.entries[k].method).sensor.empty();
    if (has_choice && cell.method.sensor.empty())
      cell.method = offer_with(cell.method, sensor_taken(inputs[cell.input].facts));
  }
  name_columns(list, cells.cells);
}

void plan_list(const BenchmarkList& list, const ListedCells& cells, const std::vector<CompareInput>& inputs,
               int repeats, ComparePlan& plan) {
  for (std::size_t k = 0; k < list.entries.size(); ++k) {
    const ListedCell& cell = cells.cells[k];
    const int seeds = cell.method.has_seed ? repeats : 1;
    const auto add = [&](int repeat, bool again) {
      BenchmarkEntry entry = list.entries[k];
      if (entry.ground_truth.empty()) entry.has_ground_truth = inputs[cell.input].facts.has_ground_truth;
      if (repeat > 1) {
        entry.name += fmt::format(" repeat {}", repeat);
        entry.method.flags.insert(entry.method.flags.end(), {"--seed", fmt::format("{}", repeat)});
      }
      if (again) entry.name += " again";
      plan.list.entries.push_back(std::move(entry));
      plan.runs.push_back({cell.input, cell.column, repeat, again, ""});
    };
    for (int repeat = 1; repeat <= seeds; ++repeat) add(repeat, false);
    if (repeats > 1) add(1, true);
  }
}

}  // namespace rastro::cli
