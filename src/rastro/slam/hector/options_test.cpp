// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/options.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/slam/hector/hector_slam.h"

namespace rastro {
namespace {

/// Another valid value than the current one.
std::string other_value(const OptionTable& table, std::size_t i) {
  const Option& option = table.options()[i];
  if (!option.choices.empty()) return option.choices.back();
  if (std::holds_alternative<bool*>(option.target)) return table.value_of(i) == "true" ? "false" : "true";
  if (std::holds_alternative<int*>(option.target)) return std::to_string(static_cast<int>(option.maximum));
  return std::to_string(0.5 * (option.minimum + option.maximum));
}

TEST(HectorOptions, EverySettingIsReadBackFromTheTable) {
  HectorOptions written, read;
  OptionTable writer = option_table(written), reader = option_table(read);
  for (std::size_t i = 0; i < writer.options().size(); ++i)
    writer.set(writer.options()[i].name, other_value(writer, i), "test");
  reader.load_yaml_text(writer.to_yaml(), "test");
  for (std::size_t i = 0; i < writer.options().size(); ++i) {
    EXPECT_NE(reader.value_of(i), reader.default_of(i)) << writer.options()[i].name;
    EXPECT_EQ(reader.value_of(i), writer.value_of(i)) << writer.options()[i].name;
  }
  EXPECT_EQ(read.guess, "none");
  EXPECT_FALSE(read.loop_closing);
  EXPECT_EQ(read.levels, 6);
}

TEST(HectorOptions, InvalidValuesAreRefused) {
  HectorOptions options;
  options.cell_m = 0.0;
  EXPECT_THROW(HectorSlam(options, nullptr), Error);
  options = HectorOptions();
  options.guess = "hope";
  EXPECT_THROW(HectorSlam(options, nullptr), Error);
  options = HectorOptions();
  options.free_probability = 0.6;
  EXPECT_THROW(HectorSlam(options, nullptr), Error);
  EXPECT_NO_THROW(HectorSlam(HectorOptions(), nullptr));
}

}  // namespace
}  // namespace rastro
