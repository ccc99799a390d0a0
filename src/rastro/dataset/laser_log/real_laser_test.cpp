// SPDX-License-Identifier: Apache-2.0
// Recorded logs, which are not part of the project; skipped, saying so, where they are not there.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "rastro/base/recorded_data_testing.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/open.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {
namespace {

struct Expected {
  const char* log;
  std::int64_t frames;
  std::int64_t broken;
  std::size_t beams;
  double max_range;
  const char* relations;  ///< Empty where there are none.
  std::size_t relation_count;
};

void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.log; }

class RealLaser : public testing::TestWithParam<Expected> {};

/// Relations whose both stamps are among those of the scans.
std::size_t count_found(const std::string& relations, const std::set<TimeNs>& stamps) {
  std::size_t found = 0;
  const auto text = read_text_file(relations);
  for (const auto& line : content_lines(text)) {
    const auto words = split_words(line.text);
    const auto from = parse_stamp(words.at(0), StampUnit::seconds), to = parse_stamp(words.at(1), StampUnit::seconds);
    found += stamps.count(from.value()) * stamps.count(to.value());
  }
  return found;
}

TEST_P(RealLaser, IsReadWholeAndHoldsTheStampsOfTheBenchmark) {
  const auto& expected = GetParam();
  const std::filesystem::path logs = "laser";
  const auto path = recorded_data(logs / expected.log);
  if (!path) GTEST_SKIP() << no_recorded_data(logs / expected.log);
  const auto source = open(path->string());
  EXPECT_EQ(source->info().frame_count, expected.frames);
  EXPECT_TRUE(source->info().has_odometry);
  std::set<TimeNs> stamps;
  std::int64_t broken = 0, count = 0;
  for (; count + broken < expected.frames + 1;) {
    try {
      const auto frame = source->next();
      if (!frame) break;
      ++count;
      stamps.insert(frame->stamp);
      ASSERT_EQ(frame->scan->ranges.size(), expected.beams);
      ASSERT_EQ(frame->scan->max_range, expected.max_range);
    } catch (const Error&) {
      ++broken;
    }
  }
  EXPECT_EQ(count + broken, expected.frames);
  EXPECT_EQ(broken, expected.broken);
  if (*expected.relations == '\0') return;
  EXPECT_EQ(count_found(recorded_data_path(logs / expected.relations).string(), stamps), expected.relation_count);
}

INSTANTIATE_TEST_SUITE_P(Laser, RealLaser,
                         testing::Values(Expected{"intel.clf.gz", 13631, 0, 180, static_cast<double>(81.83F),
                                                  "intel.relations", 2984},
                                         Expected{"aces.clf.gz", 7374, 0, 180, 50.0, "aces.relations", 1279},
                                         Expected{"minesrover/exp1.dat.gz", 756, 0, 682, 5.6, "", 0},
                                         Expected{"minesrover/test_lab.dat.gz", 591, 1, 682, 5.6, "", 0},
                                         Expected{"minesrover/test_lab2.dat.gz", 405, 1, 682, 5.6, "", 0}));

}  // namespace
}  // namespace rastro
