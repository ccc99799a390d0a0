// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/append_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"

namespace rastro {
namespace {

TEST(AppendFile, EveryPieceIsThereAtOnce) {
  const auto path = scratch_path("append_file_pieces.txt");
  AppendFile file(path);
  EXPECT_EQ(read_whole_file(path), "");
  file.append("one\n");
  EXPECT_EQ(read_whole_file(path), "one\n");
  file.append("two\n");
  EXPECT_EQ(read_whole_file(path), "one\ntwo\n");
}

TEST(AppendFile, DropsTheFormerContent) {
  const auto path = scratch_path("append_file_old.txt");
  write_whole_file(path, "old");
  const AppendFile file(path);
  EXPECT_EQ(read_whole_file(path), "");
}

TEST(AppendFile, SaysWhichFileCannotBeWritten) {
  EXPECT_THROW(AppendFile("/nowhere/at/all.txt"), Error);
  EXPECT_THROW(write_whole_file("/nowhere/at/all.txt", "x"), Error);
  EXPECT_THROW(read_whole_file("/nowhere/at/all.txt"), Error);
  EXPECT_THROW(read_whole_file(scratch_folder("folder")), Error);
}

TEST(AppendFile, DiskFullIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  AppendFile file("/dev/full");
  EXPECT_THROW(file.append("x"), Error);
}

TEST(WriteWholeFile, ReplacesAndLeavesNoPartialFile) {
  const auto path = scratch_path("whole_file.txt");
  write_whole_file(path, "a longer text");
  write_whole_file(path, "short");
  EXPECT_EQ(read_whole_file(path), "short");
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".partial"));
}

TEST(WriteWholeFile, JoinsPiecesAndKeepsTheFormerFileUntilTheLast) {
  const auto path = scratch_path("pieces.txt");
  write_whole_file(path, "old");
  write_whole_file(path, [&path](const PutPiece& put) {
    put("two ");
    EXPECT_EQ(read_whole_file(path), "old");
    put("pieces");
  });
  EXPECT_EQ(read_whole_file(path), "two pieces");
}

TEST(WriteWholeFile, AFailedOneLeavesTheFormerFileAlone) {
  const auto path = scratch_path("failed.txt");
  write_whole_file(path, "old");
  const auto fail_later = [](const PutPiece& put) {
    put("begun");
    throw Error("no space is left", "here", "");
  };
  EXPECT_THROW(write_whole_file(path, fail_later), Error);
  EXPECT_EQ(read_whole_file(path), "old");
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".partial"));
  const auto folder = scratch_folder("failed");
  write_whole_file(folder / "in_the_way", "");
  EXPECT_THROW(write_whole_file(folder, "text"), Error);
  EXPECT_FALSE(std::filesystem::exists(folder.string() + ".partial"));
}

TEST(WriteWholeFile, ALinkStaysALink) {
  const auto target = scratch_path("target.txt"), link = scratch_path("link.txt");
  write_whole_file(target, "a former text");
  std::filesystem::remove(link);
  std::filesystem::create_symlink(target, link);
  write_whole_file(link, "new");
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(read_whole_file(target), "new");
}

TEST(WriteWholeFile, APipeIsWrittenIfSomebodyReadsIt) {
  const auto pipe = scratch_path("pipe");
  std::filesystem::remove(pipe);
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(write_whole_file(pipe, "x"), Error);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_whole_file(pipe, "text");
  char text[8] = {};
  EXPECT_EQ(::read(reader, text, sizeof text), 4);
  ::close(reader);
  EXPECT_STREQ(text, "text");
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

}  // namespace
}  // namespace rastro
