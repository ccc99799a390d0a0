// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/paper_lengths.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro::cli {
namespace {

Comparison two_maps_of_bedroom() {
  Comparison comparison;
  CompareInput bedroom, hall;
  bedroom.name = "bedroom";
  bedroom.input.world = "bedroom";
  hall.name = "hall";
  hall.input.world = "hall";
  comparison.inputs = {bedroom, hall};
  comparison.table.add("bedroom", "orb rgbd", "length/blue box width_m", {0.002, 1, 1, ""});
  comparison.table.add("bedroom", "orb rgbd", "length/blue box width_m", {-0.004, 2, 1, ""});
  comparison.table.add("bedroom", "hector scan", "ate_m", {0.1, 1, 1, ""});
  return comparison;
}

TEST(PaperLengths, HaveOurMeasuresBesideThePapers) {
  const auto tables = paper_length_tables(two_maps_of_bedroom());
  ASSERT_EQ(tables.size(), 1U) << "the paper has no hall";
  EXPECT_NE(tables[0].title.find("table 1"), std::string::npos);
  ASSERT_EQ(tables[0].rows.size(), 4U) << "the head, and three lengths of orb";
  const std::vector<std::string> width = {
      "blue box width (0.32 m)", "orb rgbd", "2", "0.3190", "0.0040", "0.280", "0.250"};
  EXPECT_EQ(tables[0].rows[1], width);
  const std::vector<std::string> bed = {"bed length (2 m)", "orb rgbd", "0", "-", "-", "1.050", "1.000"};
  EXPECT_EQ(tables[0].rows[3], bed) << "what was not measured is said";
}

/// A typing error in our copy would most likely show here.
TEST(PaperLengths, PublishedFiguresAreConsistent) {
  int beyond = 0;
  for (const PublishedLength& length : published_lengths()) {
    EXPECT_EQ(length.measured.size(), 4U);
    for (const auto& each : length.measured) beyond += std::abs(each.mean_m - length.true_m) > each.max_error_m + 1e-9;
  }
  EXPECT_EQ(beyond, 1) << "RGB-D SLAM on the bed: 1.77 m of 2 m, with 0.2 m as the maximum error";
}

}  // namespace
}  // namespace rastro::cli
