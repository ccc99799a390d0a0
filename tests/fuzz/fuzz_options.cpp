// SPDX-License-Identifier: Apache-2.0
// Options files and --set texts: either an Error of one line, or a table that writes itself and reads itself back
// equal.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "rastro/base/error.h"
#include "rastro/base/options.h"

namespace {

struct Settings {
  bool flag = false;
  int count = 3;
  std::int64_t offset = -1;
  std::uint64_t seed = 1;
  double ratio = 0.5;
  std::string mode = "fast";
  std::string name = "none";
};

rastro::OptionTable table_of(Settings& settings) {
  rastro::OptionTable table;
  table.add({.name = "flag", .target = &settings.flag, .unit = "", .why = "A switch."});
  table.add({.name = "count", .target = &settings.count, .unit = "px", .why = "A size.", .minimum = 1, .maximum = 9});
  table.add({.name = "offset", .target = &settings.offset, .unit = "ns", .why = "Any whole number."});
  table.add({.name = "seed", .target = &settings.seed, .unit = "", .why = "Any whole number from 0."});
  table.add({.name = "ratio", .target = &settings.ratio, .unit = "", .why = "Any number."});
  table.add({.name = "mode", .target = &settings.mode, .unit = "", .why = "A choice.", .choices = {"fast", "slow"}});
  table.add({.name = "name", .target = &settings.name, .unit = "", .why = "Any line."});
  return table;
}

void expect(bool promise) {
  if (!promise) std::abort();
}

void expect_round_trip(const rastro::OptionTable& table) {
  Settings read_back;
  rastro::OptionTable other = table_of(read_back);
  other.load_yaml_text(table.to_yaml(), "round trip");
  for (std::size_t i = 0; i < table.options().size(); ++i) expect(other.value_of(i) == table.value_of(i));
}

template <typename Read>
void expect_value_or_line(const Read& read) {
  Settings settings;
  rastro::OptionTable table = table_of(settings);
  try {
    read(table);
    expect_round_trip(table);
  } catch (const rastro::Error& error) {
    expect(std::string(error.what()).find('\n') == std::string::npos);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  expect_value_or_line([&](rastro::OptionTable& table) { table.load_yaml_text(text, "fuzz"); });
  expect_value_or_line([&](rastro::OptionTable& table) { table.set_assignment(text, "--set"); });
  return 0;
}
