// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/growing_map_file.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <future>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/map/file/image_bytes.h"
#include "rastro/map/file/row_source.h"
#include "rastro/map/file/write_map.h"

namespace rastro {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto write_every = std::chrono::milliseconds(500);
constexpr auto commit_rows_every = std::chrono::milliseconds(400);
constexpr auto ahead = std::chrono::milliseconds(100);  ///< Time to build a map.
constexpr std::size_t longest_log = 16 << 20;           ///< Bytes put before a checkpoint.
constexpr int least_rest = 9;  ///< Pause in units of the writing time: uses a tenth of one core.

/// Images in the growing file, later in the finished one. Uncommitted ones are visible only through the same
/// connection.
class ImagesInFile : public ImageStore {
 public:
  explicit ImagesInFile(std::shared_ptr<const SharedDatabase> file)
      : rows_(std::move(file), table_of_layer("images")) {}
  PackedImages read(KeyframeId keyframe) const override { return read_images(rows_.row(keyframe), "images"); }

 private:
  FileRows rows_;
};

}  // namespace

/// Timing only decides when a map reaches the disk. The database mutex is never waited for while holding the other one.
class GrowingMapFile::State {
 public:
  State(std::filesystem::path file, std::string recording)
      : file_(std::move(file)), recording_(std::move(recording)), images_(std::make_shared<ImagesInFile>(database_)) {}
  ~State() { stop(false); }

  /// None while one is written: it would wait for the rest after that, and take memory.
  bool wants_map() const {
    const std::lock_guard lock(mutex_);
    return !waiting_ && !writing_ && Clock::now() + ahead >= next_;
  }

  void keep(std::shared_ptr<const Map> map) {
    {
      const std::lock_guard lock(mutex_);
      check_open();
      waiting_ = std::move(map);
      start();
    }
    wake_.notify_all();
  }

  /// The writer is told of a row that is there: told before, it could commit without it.
  void add_row(const std::string& layer, KeyframeId keyframe, const std::string& body) {
    {
      const std::lock_guard lock(mutex_);
      check_open();
      start();
    }
    put_row(table_of_layer(layer), keyframe, body);
    {
      const std::lock_guard lock(mutex_);
      if (!rows_added_) rows_since_ = Clock::now();
      rows_added_ = true;
    }
    wake_.notify_all();
  }

  std::shared_ptr<const ImageStore> images() const { return images_; }
  std::shared_ptr<const RowStore> rows(const std::string& layer) const {
    return std::make_shared<FileRows>(database_, table_of_layer(layer));
  }

  void finish(const Map& map) {
    const std::filesystem::path aside = write_map_beside(map, file_);
    stop(true);
    const std::lock_guard lock(database_->mutex);
    close();
    written_ = {};
    replace_file(aside, file_);
    database_->database.emplace(Database::open(file_));
  }

 private:
  void check_open() const {
    RASTRO_CHECK(!stopping_, "a map is kept before it is finished");
    if (failure_) std::rethrow_exception(failure_);
  }

  void start() {
    if (!writer_.joinable()) writer_ = std::thread([this] { write_now_and_then(); });
  }

  /// Requires the database mutex. The file is replaced next, by a map that is whole without its last rows: after a
  /// failed write, as on a full disk, there is no transaction left to commit, and nothing to report.
  void close() {
    if (!database_->database) return;
    try {
      database_->database->run("COMMIT");
    } catch (const Error&) {
    }
    database_->database.reset();
  }

  /// Requires the database mutex.
  Database& open() {
    if (database_->database) return *database_->database;
    Database& database = database_->database.emplace(Database::create(file_));
    // The log is append-only and safe against a kill in the middle.
    database.run("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; PRAGMA wal_autocheckpoint=0; BEGIN");
    return database;
  }

  void put_row(const std::string& table, KeyframeId keyframe, const std::string& body) {
    const std::lock_guard lock(database_->mutex);
    Database& database = open();
    database.need_table(table);
    database.put(table, keyframe, body);
  }

  /// Methods do not know where their frames come from.
  std::vector<MapSession> with_recording(std::vector<MapSession> sessions) const {
    if (!recording_.empty() && !sessions.empty() && sessions.back().recording.empty())
      sessions.back().recording = recording_;
    return sessions;
  }

  void write(const Map* map) {
    const std::lock_guard lock(database_->mutex);
    Database& database = open();
    if (map)
      write_changes(*map, with_recording(map->sessions), LayersWritten::without_those_that_stay_in_file, written_,
                    database);
    database.run("COMMIT; BEGIN");
  }

  /// A long log goes into the file while others read and write, which may take as long as many frames; then what came
  /// since, as nobody else writes: only then the log begins anew.
  void shorten_log() {
    if (moving_.valid()) {
      if (moving_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout) return;
      moving_.get();
      const std::lock_guard lock(database_->mutex);
      Database& database = open();
      in_file_ = database.bytes_put();
      return database.run("COMMIT; PRAGMA wal_checkpoint(PASSIVE); BEGIN");
    }
    std::unique_lock lock(database_->mutex);
    const bool is_long = open().bytes_put() >= in_file_ + longest_log;
    lock.unlock();
    if (is_long) moving_ = moved_log();
  }

  /// By a thread of its own, so that maps are written meanwhile; at once where none can be had.
  std::future<void> moved_log() const {
    try {
      return std::async(std::launch::async, move_log, file_);
    } catch (const std::system_error&) {
      return std::async(std::launch::deferred, move_log, file_);
    }
  }

  static void move_log(const std::filesystem::path& file) {
    try {
      Database::checkpoint(file);
    } catch (const Error&) {
      // Moved away or deleted, it can still be written by who has it open.
    }
  }

  /// A new keyframe waits only for the rest after the last write, so that a killed run has lost none but the last.
  Clock::time_point due() const {
    if (!waiting_) return rows_since_ + commit_rows_every;
    return waiting_->keyframes.size() > written_keyframes_ ? rested_ : next_;
  }

  void write_now_and_then() {
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [this] { return waiting_ || rows_added_ || stopping_; });
      while (!stopping_ && Clock::now() < due()) wake_.wait_until(lock, due());
      const auto map = std::exchange(waiting_, nullptr);
      rows_added_ = false;
      if (!dropping_ && !failure_) write_unlocked(lock, map);
      if (stopping_ && (!waiting_ || dropping_)) return;
    }
  }

  void write_unlocked(std::unique_lock<std::mutex>& lock, const std::shared_ptr<const Map>& map) {
    writing_ = map != nullptr;
    lock.unlock();
    const Clock::time_point begin = Clock::now();
    std::exception_ptr failure;
    try {
      write(map.get());
      shorten_log();
    } catch (...) {
      failure = std::current_exception();
    }
    const Clock::time_point end = Clock::now();
    lock.lock();
    writing_ = false;
    failure_ = failure;
    if (!map) return;
    written_keyframes_ = map->keyframes.size();
    rested_ = end + least_rest * (end - begin);
    next_ = std::max<Clock::time_point>(begin + write_every, rested_);
  }

  /// Writes the map kept last first, unless `drop`.
  void stop(bool drop) {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
      dropping_ = drop;
    }
    wake_.notify_all();
    if (writer_.joinable()) writer_.join();
    if (moving_.valid()) moving_.wait();
  }

  const std::filesystem::path file_;
  const std::string recording_;
  const std::shared_ptr<SharedDatabase> database_ = std::make_shared<SharedDatabase>();
  const std::shared_ptr<const ImageStore> images_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::shared_ptr<const Map> waiting_;
  std::size_t in_file_ = 0;   ///< Of the bytes put, those at the last checkpoint; only the writer's.
  std::future<void> moving_;  ///< The log that goes into the file; only the writer's.
  bool rows_added_ = false, writing_ = false, stopping_ = false, dropping_ = false;
  Clock::time_point rested_{};      ///< Earliest time of the next write ...
  Clock::time_point next_{};        ///< ... and of one without new keyframes.
  Clock::time_point rows_since_{};  ///< When the first row was added that is not committed.
  std::size_t written_keyframes_ = 0;
  std::exception_ptr failure_;
  std::thread writer_;
  WrittenMap written_;  ///< The writer's own; others may use it once it has ended.
};

GrowingMapFile::GrowingMapFile(std::filesystem::path file, std::string recording)
    : state_(std::make_unique<State>(std::move(file), std::move(recording))) {}
GrowingMapFile::~GrowingMapFile() = default;
bool GrowingMapFile::wants_map() const { return state_->wants_map(); }
void GrowingMapFile::keep(std::shared_ptr<const Map> map) { state_->keep(std::move(map)); }
void GrowingMapFile::add_images(KeyframeId keyframe, PackedImages images) {
  state_->add_row(ImageLayer::layer_name, keyframe, body_of(images));
}
void GrowingMapFile::add_row(const std::string& layer, KeyframeId keyframe, const std::string& body) {
  state_->add_row(layer, keyframe, body);
}
std::shared_ptr<const RowStore> GrowingMapFile::rows(const std::string& layer) const { return state_->rows(layer); }
std::shared_ptr<const ImageStore> GrowingMapFile::images() const { return state_->images(); }
void GrowingMapFile::finish(const Map& map) { state_->finish(map); }

}  // namespace rastro
