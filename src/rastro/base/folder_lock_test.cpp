// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/folder_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"

namespace rastro {
namespace {

TEST(FolderLock, OneAtATime) {
  const auto folder = scratch_folder("locked");
  {
    const FolderLock first(folder);
    EXPECT_THAT([&] { FolderLock second(folder); },
                testing::ThrowsMessage<Error>(testing::HasSubstr("another run is writing to this folder")));
  }
  EXPECT_NO_THROW(FolderLock again(folder));
  EXPECT_TRUE(std::filesystem::is_empty(folder)) << "no file is left behind";
}

TEST(FolderLock, LeavesAMissingFolderToItsWriter) { EXPECT_NO_THROW(FolderLock none(scratch_path("none"))); }

}  // namespace
}  // namespace rastro
