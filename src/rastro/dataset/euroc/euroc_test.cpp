// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/euroc/euroc.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::HasSubstr;

TEST(Euroc, GroundTruthInMicrosecondsIsNoticed) {
  for (const std::string name : {"state_groundtruth_estimate0", "mocap0"}) {
    const ScratchFolder folder;
    write_euroc(folder, 2);
    folder.write("mav0/" + name + "/data.csv", "#t\n1400000000000000,1,2,3,1,0,0,0\n1400000000050000,2,2,3,1,0,0,0\n");
    const auto source = open(folder.path());
    ASSERT_EQ(source->info().ground_truth.size(), 2u) << name;
    EXPECT_EQ(source->info().ground_truth[1].stamp, 1400000000050000000);
    EXPECT_THAT(source->info().warnings, Contains(HasSubstr(name + "/data.csv: timestamps look like us, not ns")));
  }
}

TEST(Euroc, PositionsOfAPrismMayBeInMicrosecondsToo) {
  const ScratchFolder folder;
  write_euroc(folder, 2);
  folder.write("mav0/leica0/data.csv", "#t\n1400000000000000,1,2,3\n1400000000050000,2,2,3\n");
  const auto source = open(folder.path());
  ASSERT_EQ(source->info().ground_truth.size(), 2u);
  EXPECT_EQ(source->info().ground_truth[0].stamp, 1400000000000000000);
}

}  // namespace
}  // namespace rastro
