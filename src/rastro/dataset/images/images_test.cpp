// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

using testing::Contains;

TEST(OpenImages, NamesInMicrosecondsGiveTheStamps) {
  const ScratchFolder folder;
  folder.write_gray("1418381798086398.png", 1);
  folder.write_gray("1418381798136382.png", 2);
  const auto source = open(folder.path());
  EXPECT_TRUE(source->info().has_stamps);
  EXPECT_THAT(source->info().warnings, Contains("stamps are taken from the file names, as microseconds"));
  EXPECT_EQ(source->next()->stamp, 1418381798086398000);
  EXPECT_EQ(source->next()->stamp, 1418381798136382000);
}

}  // namespace
}  // namespace rastro
