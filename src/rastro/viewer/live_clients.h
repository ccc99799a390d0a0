// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "rastro/viewer/live_messages.h"

namespace rastro::detail {

/// What clients ask for, from the server's thread to the run's.
class LiveInbox {
 public:
  void put(LiveCommand command);
  /// The oldest one; waits for one at most so long.
  std::optional<LiveCommand> take(std::chrono::milliseconds at_most);

 private:
  static constexpr std::size_t most_waiting = 64;  ///< More is a fault of a client, and is left out.
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<LiveCommand> waiting_;
};

/// A message as all clients get it.
struct LiveMessage {
  enum class Kind : std::uint8_t { hello, frame, image, place, scene, status, calibration };
  Kind kind = Kind::frame;
  std::shared_ptr<const std::string> bytes;
};

class LiveClient;

/// The pages that watch a run. Of the server's thread but for count().
class LiveClients {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  LiveClients(LiveMessage hello, LiveInbox& inbox) : hello_(std::move(hello)), inbox_(inbox) {}

  /// Answers the request of a WebSocket. Of more than 32 clients the new one is closed.
  void accept(boost::asio::ip::tcp::socket socket, const Request& request);
  /// To all of them, at once and without waiting: a client that is too slow misses frames and images, and is told how
  /// many frames.
  void send(const LiveMessage& message);
  /// The last scene is told to nobody any more.
  void forget_scene();
  int count() const { return count_; }

 private:
  static constexpr std::size_t most_clients = 32;
  void forget_closed();

  LiveMessage hello_;
  LiveInbox& inbox_;
  std::optional<LiveMessage> status_, scene_, calibration_;  ///< The last ones, for who comes later.
  std::list<std::shared_ptr<LiveClient>> clients_;
  std::atomic<int> count_ = 0;
};

}  // namespace rastro::detail
