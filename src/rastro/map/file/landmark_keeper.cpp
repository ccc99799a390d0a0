// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/landmark_keeper.h"

#include <algorithm>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/map/file/landmark_tables.h"
#include "rastro/map/file/save_map.h"

namespace rastro {
namespace {

constexpr auto write_every = std::chrono::milliseconds(1000);
constexpr auto ahead = std::chrono::milliseconds(100);  ///< For putting a map together.
constexpr int least_rest = 9;                           ///< Times as long as writing took: a tenth of one processor.

}  // namespace

LandmarkKeeper::~LandmarkKeeper() { stop(); }

void LandmarkKeeper::keep(std::shared_ptr<const LandmarkMap> map) {
  {
    const std::lock_guard lock(mutex_);
    RASTRO_CHECK(!stopping_, "a map is kept before it is finished");
    if (failure_) std::rethrow_exception(failure_);
    waiting_ = std::move(map);
    if (!writer_.joinable()) writer_ = std::thread([this] { write_now_and_then(); });
  }
  wake_.notify_all();
}

bool LandmarkKeeper::wants_map() const {
  const std::lock_guard lock(mutex_);
  return !waiting_ && Clock::now() + ahead >= next_;
}

void LandmarkKeeper::finish(const LandmarkMap& map) {
  const std::filesystem::path aside = write_map_beside(map, file_);
  {
    const std::lock_guard lock(mutex_);
    dropping_ = true;
  }
  stop();
  // Closed before it is replaced: its log must not stay beside a file that it does not belong to.
  database_.reset();
  written_.reset();
  replace_file(aside, file_);
}

void LandmarkKeeper::write_now_and_then() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return waiting_ || stopping_; });
    wake_.wait_until(lock, next_, [this] { return stopping_; });
    const auto map = std::exchange(waiting_, nullptr);
    if (map && !dropping_ && !failure_) {
      lock.unlock();
      const Clock::time_point begin = Clock::now();
      std::exception_ptr failure;
      try {
        write(*map);
        written_ = map;
      } catch (...) {
        failure = std::current_exception();
      }
      const Clock::time_point end = Clock::now();
      lock.lock();
      failure_ = failure;
      next_ = std::max<Clock::time_point>(begin + write_every, end + least_rest * (end - begin));
    }
    if (stopping_ && (!waiting_ || dropping_)) return;
  }
}

void LandmarkKeeper::write(const LandmarkMap& map) {
  if (!database_) {
    database_.emplace(Database::create(file_, MapKind::landmarks));
    database_->run("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; PRAGMA wal_autocheckpoint=4000");
  }
  database_->run("BEGIN");
  write_changes(written_.get(), map, *database_);
  database_->run("COMMIT");
}

void LandmarkKeeper::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (writer_.joinable()) writer_.join();
}

}  // namespace rastro
