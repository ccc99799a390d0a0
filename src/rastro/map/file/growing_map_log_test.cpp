// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

#include "rastro/base/scratch_testing.h"
#include "rastro/map/file/growing_map_file.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t row_bytes = 1 << 20;

std::string row_of(KeyframeId keyframe) { return std::string(row_bytes, static_cast<char>('a' + keyframe % 26)); }

std::uintmax_t size_of(const fs::path& file) {
  std::error_code code;
  const std::uintmax_t size = fs::file_size(file, code);
  return code ? 0 : size;
}

/// Rows of which a batch is long enough for a checkpoint; returns once they are in the file itself.
void add_batch(GrowingMapFile& growing, const fs::path& file, KeyframeId first, KeyframeId count) {
  for (KeyframeId id = first; id < first + count; ++id) growing.add_row("words", id, row_of(id));
  const auto all = static_cast<std::uintmax_t>(first + count) * row_bytes;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(15);
  while (size_of(file) < all && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ASSERT_GE(size_of(file), all) << "after " << first + count << " rows";
}

/// Without an end of the log it would take as much room as the map, and each checkpoint longer than the one before.
TEST(GrowingMapFile, ItsLogBeginsAnewAndRowsStayReadableMeanwhile) {
  const fs::path file = scratch_path("long_log.rastro");
  GrowingMapFile growing(file);
  constexpr KeyframeId batch = 18;
  for (KeyframeId first = 0; first < 5 * batch; first += batch) {
    add_batch(growing, file, first, batch);
    EXPECT_EQ(growing.rows("words")->row(first / 2), row_of(first / 2));
  }
  EXPECT_LT(size_of(file.string() + "-wal"), 3 * batch * row_bytes) << "what is moved, and what comes meanwhile";
}

TEST(GrowingMapFile, AFileThatIsMovedAwayIsStillWritten) {
  const fs::path file = scratch_path("moved_log.rastro"), moved = scratch_path("moved_to.rastro");
  GrowingMapFile growing(file);
  growing.add_row("words", 0, row_of(0));
  for (const char* ending : {"", "-wal", "-shm"}) fs::rename(file.string() + ending, moved.string() + ending);
  for (KeyframeId id = 1; id < 200 && size_of(moved) < 20 * row_bytes; ++id) {
    growing.add_row("words", id, row_of(id));
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  EXPECT_GE(size_of(moved), 20 * row_bytes);
  EXPECT_EQ(growing.rows("words")->row(7), row_of(7));
}

}  // namespace
}  // namespace rastro
