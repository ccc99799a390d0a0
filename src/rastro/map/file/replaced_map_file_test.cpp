// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <thread>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/file/growing_map_file.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/images/room_map_testing.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

/// Another process that has a map open while it grows: the log stays when the writer closes.
class OtherReader {
 public:
  explicit OtherReader(const fs::path& file) {
    EXPECT_EQ(sqlite3_open_v2(file.c_str(), &connection_, SQLITE_OPEN_READWRITE, nullptr), SQLITE_OK);
    rows();
  }
  ~OtherReader() { sqlite3_close(connection_); }
  OtherReader(const OtherReader&) = delete;
  OtherReader& operator=(const OtherReader&) = delete;

  int rows() {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(connection_, "SELECT count(*) FROM keyframes", -1, &statement, nullptr);
    const int count = sqlite3_step(statement) == SQLITE_ROW ? sqlite3_column_int(statement, 0) : -1;
    sqlite3_finalize(statement);
    return count;
  }

 private:
  sqlite3* connection_ = nullptr;
};

bool has_log(const fs::path& file) { return fs::exists(file.string() + "-wal") || fs::exists(file.string() + "-shm"); }

/// By the writer's thread: the first transaction is over.
void wait_until_written(const fs::path& file, int keyframes) {
  const auto is_written = [&] { return fs::exists(file) && OtherReader(file).rows() == keyframes; };
  for (int tries = 0; tries < 1000 && !is_written(); ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_TRUE(is_written());
}

/// The file of a run that was killed after `map` was written: its log beside it holds all.
fs::path file_of_killed_run(const Map& map, const std::string& name) {
  const fs::path file = scratch_path(name), source = scratch_path("of_run.rastro");
  GrowingMapFile growing(source);
  growing.keep(std::make_shared<Map>(map));
  wait_until_written(source, static_cast<int>(map.keyframes.size()));
  for (const char* ending : {"", "-wal"}) {
    fs::remove(file.string() + ending);
    fs::copy_file(source.string() + ending, file.string() + ending);
  }
  return file;
}

TEST(ReplacedMapFile, TheLogOfAKilledRunIsReadFirstAndGoesWithIt) {
  const Map map = make_test_map(4);
  const fs::path file = file_of_killed_run(map, "killed.rastro");
  const auto read = load_map(file);
  ASSERT_EQ(read->keyframes.size(), 4U) << "of the log";
  Map fewer = make_test_map(2);
  save_map(fewer, file);
  EXPECT_FALSE(has_log(file));
  EXPECT_EQ(load_map(file)->keyframes.size(), 2U);
  const fs::path plain = scratch_path("plain_of_two.rastro");
  save_map(fewer, plain);
  EXPECT_EQ(read_whole_file(file), read_whole_file(plain));
}

TEST(ReplacedMapFile, ARunDuringWhichItWasReadEndsAsItsMap) {
  const fs::path file = scratch_path("watched.rastro");
  GrowingMapFile growing(file);
  growing.keep(std::make_shared<Map>(make_test_map(4)));
  wait_until_written(file, 4);
  OtherReader reader(file);
  ASSERT_EQ(reader.rows(), 4);
  growing.finish(make_test_map(2));
  EXPECT_FALSE(has_log(file));
  EXPECT_EQ(check_map_file(file).damage, "");
  EXPECT_EQ(load_map(file)->keyframes.size(), 2U);
  EXPECT_EQ(reader.rows(), 4) << "of the file that it opened";
}

/// Lets no file of this process grow beyond some bytes, as a full disk does.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) : former_action_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &former_);
    const rlimit small{bytes, former_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallDisk() {
    ::setrlimit(RLIMIT_FSIZE, &former_);
    std::signal(SIGXFSZ, former_action_);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

 private:
  rlimit former_{};
  void (*former_action_)(int);
};

bool fails_within_seconds(const std::function<void()>& work) {
  try {
    for (int tries = 0; tries < 100; ++tries) {
      work();
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  } catch (const Error&) {
    return true;
  }
  return false;
}

TEST(ReplacedMapFile, AMapIsPutInPlaceAfterAWriteFailed) {
  const fs::path file = scratch_path("disk_was_full.rastro");
  const Map map = make_test_map(3);
  GrowingMapFile growing(file);
  growing.keep(std::make_shared<Map>(map));
  wait_until_written(file, 3);
  {
    const SmallDisk disk(fs::file_size(file.string() + "-wal"));
    growing.add_row("images", 7, std::string(100'000, 'x'));
    ASSERT_TRUE(fails_within_seconds([&] { growing.keep(std::make_shared<Map>(map)); }));
  }
  growing.finish(map);
  EXPECT_FALSE(fs::exists(file.string() + ".new"));
  EXPECT_EQ(check_map_file(file).damage, "");
  EXPECT_TRUE(check_map_file(file).finished);
  EXPECT_EQ(load_map(file)->keyframes.size(), 3U);
}

}  // namespace
}  // namespace rastro
