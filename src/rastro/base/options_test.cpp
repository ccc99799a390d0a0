// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/options.h"

#include <gmock/gmock.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/log.h"

namespace rastro {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

struct Settings {
  bool flag = false;
  int count = 30;
  std::int64_t offset_ns = -5;
  std::uint64_t seed = 1;
  double ratio = 0.1;
  std::string mode = "fast";
  std::string name;
};

OptionTable table_of(Settings& settings) {
  OptionTable table;
  table.add({.name = "flag", .target = &settings.flag, .unit = "", .why = "A switch."});
  table.add(
      {.name = "count_px", .target = &settings.count, .unit = "px", .why = "A size.", .minimum = 1, .maximum = 500});
  table.add({.name = "offset_ns", .target = &settings.offset_ns, .unit = "ns", .why = "A shift."});
  table.add({.name = "seed", .target = &settings.seed, .unit = "", .why = "Of random draws."});
  table.add({.name = "ratio", .target = &settings.ratio, .unit = "", .why = "A share.", .minimum = 0, .maximum = 1});
  table.add({.name = "mode", .target = &settings.mode, .unit = "", .why = "How.", .choices = {"fast", "slow"}});
  table.add({.name = "name", .target = &settings.name, .unit = "", .why = ""});
  return table;
}

/// The error message of a change to a new table; "" if there was none.
template <typename Change>
std::string error_of(const Change& change) {
  Settings settings;
  OptionTable table = table_of(settings);
  try {
    change(table);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

std::string set_error(const std::string& name, const std::string& value) {
  return error_of([&](OptionTable& table) { table.set(name, value, "--set"); });
}

std::string yaml_error(const std::string& text) {
  return error_of([&](OptionTable& table) { table.load_yaml_text(text, "run.yaml"); });
}

TEST(OptionTable, SetsEveryType) {
  Settings settings;
  OptionTable table = table_of(settings);
  table.set("flag", "yes", "");
  table.set("count_px", " 500 ", "");
  table.set("offset_ns", "-9223372036854775808", "");
  table.set("seed", "18446744073709551615", "");
  table.set("ratio", "1e-3", "");
  table.set("mode", "slow", "");
  table.set("name", "Grüße, = #", "");
  EXPECT_TRUE(settings.flag);
  EXPECT_EQ(settings.count, 500);
  EXPECT_EQ(settings.offset_ns, std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(settings.seed, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(settings.ratio, 1e-3);
  EXPECT_EQ(settings.mode, "slow");
  EXPECT_EQ(settings.name, "Grüße, = #");
}

TEST(OptionTable, KeepsTheDefaultsAsText) {
  Settings settings;
  OptionTable table = table_of(settings);
  table.set("ratio", "0.5", "");
  EXPECT_EQ(table.default_of(4), "0.1");
  EXPECT_EQ(table.value_of(4), "0.5");
  EXPECT_EQ(table.allowed_of(1), "1 .. 500");
  EXPECT_EQ(table.allowed_of(2), "");
  EXPECT_EQ(table.allowed_of(5), "fast | slow");
}

TEST(OptionTable, UnknownNameGetsTheNearest) {
  EXPECT_EQ(set_error("cuont_px", "1"), "--set: unknown option 'cuont_px'; did you mean 'count_px'?");
}

TEST(OptionTable, AFormerNameSetsTheOptionAndReportsTheNewName) {
  Settings settings;
  OptionTable table = table_of(settings);
  table.add_former_name("portion", "ratio");
  std::vector<std::string> lines;
  set_log_sink([&](LogLevel, const std::string& line) { lines.push_back(line); });
  table.set_assignment("portion=0.5", "--set");
  table.load_yaml_text("seed: 7\n", "run.yaml");
  set_log_sink({});
  EXPECT_EQ(settings.ratio, 0.5);
  EXPECT_EQ(lines,
            std::vector<std::string>{"--set: 'portion' is now 'ratio'; the next release will not accept the old name"});
  EXPECT_EQ(table.to_yaml().find("portion"), std::string::npos) << "only the new name is written";
  EXPECT_THROW(table.load_yaml_text("ratio: 0.1\nportion: 0.2\n", "run.yaml"), Error) << "both names are one option";
  EXPECT_THROW(table.add_former_name("seed", "ratio"), std::exception) << "an option cannot be a former name";
  EXPECT_THROW(table.add_former_name("old", "unknown"), std::exception);
}

TEST(OptionTable, AFormerChoiceSetsTheCurrentOne) {
  Settings settings;
  OptionTable table = table_of(settings);
  table.add_former_choice("mode", "sluggish", "slow");
  std::vector<std::string> lines;
  set_log_sink([&](LogLevel, const std::string& line) { lines.push_back(line); });
  table.load_yaml_text("mode: sluggish\n", "run.yaml");
  table.set("name", "sluggish", "--set");
  set_log_sink({});
  EXPECT_EQ(settings.mode, "slow");
  EXPECT_EQ(settings.name, "sluggish") << "of that option alone";
  EXPECT_THAT(lines, testing::ElementsAre(HasSubstr("run.yaml:1: 'sluggish' is now 'slow'")));
  EXPECT_THROW(table.add_former_choice("mode", "old", "unknown"), std::exception);
}

TEST(OptionTable, ErrorsNameRangeUnitAndChoices) {
  EXPECT_EQ(set_error("count_px", "501"),
            "--set: '501' is not a value of 'count_px'; give a whole number, 1 .. 500 px");
  EXPECT_EQ(set_error("count_px", "0"), "--set: '0' is not a value of 'count_px'; give a whole number, 1 .. 500 px");
  EXPECT_EQ(set_error("mode", "quick"), "--set: 'quick' is not a value of 'mode'; give one of, fast | slow");
  EXPECT_EQ(set_error("flag", "maybe"), "--set: 'maybe' is not a value of 'flag'; give one of, true | false");
}

TEST(OptionTable, RefusesInvalidNumbers) {
  for (const char* value : {"", "x", "3.5", "3 4", "99999999999", "nan"})
    EXPECT_NE(set_error("count_px", value), "") << value;
  for (const char* value : {"", "x", "nan", "inf", "1,5", "-0.1"}) EXPECT_NE(set_error("ratio", value), "") << value;
  EXPECT_NE(set_error("seed", "-1"), "");
}

TEST(OptionTable, RefusesTextThatNoFileCanStore) {
  for (const char* value :
       {"a\nb", "\x7f", "\xff", "\xc3", "\xc0\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82"}) {
    EXPECT_THAT(set_error("name", value), AllOf(HasSubstr("UTF-8"), Not(HasSubstr("\n"))));
  }
}

TEST(OptionTable, AFailedSetChangesNothing) {
  Settings settings;
  OptionTable table = table_of(settings);
  EXPECT_THROW(table.set("count_px", "501", ""), Error);
  EXPECT_EQ(settings.count, 30);
}

TEST(OptionTable, ReadsAssignments) {
  Settings settings;
  OptionTable table = table_of(settings);
  table.set_assignment(" name = a=b ", "--set");
  EXPECT_EQ(settings.name, "a=b");
  EXPECT_EQ(error_of([](OptionTable& other) { other.set_assignment("name", "--set"); }),
            "--set: 'name' is not a setting; write key=value");
}

TEST(OptionTable, YamlListsOnlyDifferences) {
  Settings settings;
  OptionTable table = table_of(settings);
  table.load_yaml_text("# a comment\ncount_px: 7\nname: 'x y'\n", "run.yaml");
  EXPECT_EQ(settings.count, 7);
  EXPECT_EQ(settings.name, "x y");
  EXPECT_EQ(settings.ratio, 0.1);
  table.load_yaml_text("", "run.yaml");
  table.load_yaml_text("%YAML:1.0\n---\ncount_px: 8\n", "run.yaml");
  EXPECT_EQ(settings.count, 8);
}

TEST(OptionTable, YamlErrorsNameFileAndLine) {
  EXPECT_EQ(yaml_error("flag: true\ncuont_px: 1\n"), "run.yaml:2: unknown option 'cuont_px'; did you mean 'count_px'?");
  EXPECT_EQ(yaml_error("seed: 1\n\nseed: 2\n"), "run.yaml:3: 'seed' is given twice; keep one of the two");
  EXPECT_THAT(yaml_error("count_px: [1]\n"), StartsWith("run.yaml:1: 'count_px' has no single value"));
  EXPECT_THAT(yaml_error("count_px:\n"), StartsWith("run.yaml:1: 'count_px' has no single value"));
  EXPECT_THAT(yaml_error("- a\n- b\n"), StartsWith("run.yaml: not a map"));
  EXPECT_THAT(yaml_error("just words\n"), StartsWith("run.yaml: not a map"));
  EXPECT_THAT(yaml_error("a: b\n--- \na: b\n"), HasSubstr("more than one YAML document"));
  EXPECT_THAT(yaml_error("name: \"a\\\x01\""), Not(HasSubstr("\x01")));  // yaml-cpp quotes the byte unchanged
  EXPECT_NE(yaml_error(",nti\xfe"), "");
  EXPECT_NE(yaml_error("seed: 1\n}\nflag: true\n"), "");
  EXPECT_THAT(yaml_error("? [a]\n: b\n"), HasSubstr("a key is not a word"));
  EXPECT_THAT(yaml_error("flag: true\ncount_px: 1: 2\n"), StartsWith("run.yaml:2: not YAML"));
}

TEST(OptionTable, WritesWhatItReads) {
  Settings settings;
  OptionTable table = table_of(settings);
  table.set("ratio", "0.30000000000000004", "");
  table.set("name", "  'quote\" \\ # : ä € 😀 ", "");
  table.set("mode", "slow", "");
  Settings read_back;
  OptionTable other = table_of(read_back);
  other.load_yaml_text(table.to_yaml(), "");
  for (std::size_t i = 0; i < table.options().size(); ++i) EXPECT_EQ(other.value_of(i), table.value_of(i));
  EXPECT_EQ(other.to_yaml(), table.to_yaml());
}

TEST(OptionTable, YamlCarriesUnitRangeAndReason) {
  Settings settings;
  EXPECT_THAT(table_of(settings).to_yaml(),
              AllOf(HasSubstr("count_px: 30  # px; 1 .. 500; A size.\n"), HasSubstr("name: \"\"\n"),
                    HasSubstr("mode: fast  # fast | slow; How.\n")));
}

TEST(OptionTable, LoadsFilesAndRefusesNonFiles) {
  const auto folder = std::filesystem::temp_directory_path() / ("rastro_options_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "good.yaml") << "count_px: 9\n";
  std::ofstream(folder / "large.yaml") << std::string((1 << 20) + 1, '#');
  Settings settings;
  OptionTable table = table_of(settings);
  table.load_yaml(folder / "good.yaml");
  EXPECT_EQ(settings.count, 9);
  const auto load = [](const std::filesystem::path& file) {
    return error_of([&](OptionTable& other) { other.load_yaml(file); });
  };
  EXPECT_THAT(load(folder / "none.yaml"), HasSubstr("none.yaml: no such file"));
  EXPECT_THAT(load(folder), HasSubstr("not a file"));
  EXPECT_THAT(load(folder / "large.yaml"), HasSubstr("larger than 1 MiB"));
  std::filesystem::remove_all(folder);
}

TEST(OptionTable, ADefaultMustBeAllowedAndNamesUnique) {
  int value = 5;
  OptionTable table;
  EXPECT_THROW(table.add({.name = "n", .target = &value, .unit = "", .why = "", .minimum = 6, .maximum = 7}), Error);
  table.add({.name = "n", .target = &value, .unit = "", .why = ""});
  EXPECT_THROW(table.add({.name = "n", .target = &value, .unit = "", .why = ""}), Fault);
}

}  // namespace
}  // namespace rastro
