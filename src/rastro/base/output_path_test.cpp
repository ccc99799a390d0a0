// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/output_path.h"

#include <gtest/gtest.h>

#include <functional>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

std::string refusal_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

std::string too_long() { return std::string(300, 'n'); }

TEST(OutputPath, AnExistingOneIsRefusedUnlessItMayBeOverwritten) {
  const fs::path file = scratch_path("there");
  EXPECT_EQ(refusal_of([&] { refuse_existing(file, false); }), "");
  write_whole_file(file, "");
  EXPECT_EQ(refusal_of([&] { refuse_existing(file, false); }),
            file.string() + ": already exists; choose another --out or add --force");
  EXPECT_EQ(refusal_of([&] { refuse_existing(file, true); }), "");
  EXPECT_EQ(refusal_of([&] { refuse_existing(file / "below", false); }), "") << "found out when it is made";
}

TEST(OutputPath, OneThatCannotBeIsRefusedInOneLine) {
  for (const bool overwrite : {false, true})
    EXPECT_EQ(refusal_of([&] { refuse_existing(too_long(), overwrite); }),
              too_long() + ": cannot be made (File name too long); choose another --out");
}

TEST(OutputFolder, IsMadeAndStaysOnlyWithSomethingInIt) {
  const fs::path folder = scratch_path("out") / "of" / "run";
  {
    const OutputFolder made(folder);
    EXPECT_TRUE(fs::is_directory(folder));
  }
  EXPECT_FALSE(fs::exists(folder));
  {
    const OutputFolder made(folder);
    write_whole_file(folder / "result", "1");
  }
  EXPECT_TRUE(fs::exists(folder / "result"));
  fs::remove(folder / "result");
  { const OutputFolder found(folder); }
  EXPECT_TRUE(fs::exists(folder)) << "not made here";
}

TEST(OutputFolder, OneThatCannotBeIsRefusedInOneLine) {
  const fs::path file = scratch_path("a_file");
  write_whole_file(file, "");
  EXPECT_EQ(refusal_of([&] { OutputFolder{file}; }),
            file.string() + ": cannot be made (Not a directory); choose another --out");
  EXPECT_EQ(refusal_of([&] { OutputFolder{file / "below"}; }),
            (file / "below").string() + ": cannot be made (Not a directory); choose another --out");
  EXPECT_EQ(refusal_of([&] { OutputFolder{too_long()}; }),
            too_long() + ": cannot be made (File name too long); choose another --out");
}

}  // namespace
}  // namespace rastro
