// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "rastro/map/file/database.h"
#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

/// Writes a growing map of landmarks on a thread of its own: what changed since it was last written, in one
/// transaction, about once a second. Time decides when a map reaches the disk and nothing else.
class LandmarkKeeper {
 public:
  explicit LandmarkKeeper(std::filesystem::path file) : file_(std::move(file)) {}
  /// Writes what was kept last, where finish() was not called.
  ~LandmarkKeeper();

  /// Takes the map and goes on at once. Throws what the writing before failed with.
  void keep(std::shared_ptr<const LandmarkMap> map);
  bool wants_map() const;
  /// Puts the finished file in the place of the growing one. Nothing may be kept afterwards.
  void finish(const LandmarkMap& map);

 private:
  using Clock = std::chrono::steady_clock;
  void write_now_and_then();
  void write(const LandmarkMap& map);
  void stop();

  const std::filesystem::path file_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::shared_ptr<const LandmarkMap> waiting_;
  Clock::time_point next_{};  ///< Nothing is written before.
  bool stopping_ = false, dropping_ = false;
  std::exception_ptr failure_;
  std::thread writer_;

  // The writer's own, and of others once it has ended.
  std::optional<Database> database_;
  std::shared_ptr<const LandmarkMap> written_;
};

}  // namespace rastro
