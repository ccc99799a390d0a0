// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/regular_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/base/text_file.h"

namespace rastro {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(RegularFile, NothingElseIsRead) {
  const auto folder = scratch_path("regular_file");
  std::filesystem::create_directories(folder);
  ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
  std::filesystem::create_symlink("fifo", folder / "link");
  const std::pair<std::filesystem::path, const char*> cases[] = {{folder / "fifo", "is a FIFO"},
                                                                 {folder / "link", "is a FIFO"},
                                                                 {folder, "is a folder"},
                                                                 {"/dev/zero", "is a device"},
                                                                 {folder / "none", "no such file"}};
  for (const auto& [path, what] : cases) {
    EXPECT_THAT([&path = path] { read_text_file(path.string()); }, ThrowsMessage<Error>(HasSubstr(what))) << path;
    EXPECT_THAT([&path = path] { read_whole_file(path); }, ThrowsMessage<Error>(HasSubstr(what))) << path;
  }
}

TEST(RegularFile, TooLargeOnesAreRefusedUnread) {
  const auto file = scratch_path("sparse");
  write_whole_file(file, "fx: 1\n");
  EXPECT_NO_THROW(require_regular_file(file, 6));
  EXPECT_THAT([&] { require_regular_file(file, 5); }, ThrowsMessage<Error>(HasSubstr("too much")));
  std::filesystem::resize_file(file, std::uintmax_t{8} << 30);
  EXPECT_THAT([&] { read_text_file(file.string()); }, ThrowsMessage<Error>(HasSubstr("has 8192 MiB")));
  EXPECT_THAT([&] { read_whole_file(file); }, ThrowsMessage<Error>(HasSubstr("has 8192 MiB")));
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace rastro
