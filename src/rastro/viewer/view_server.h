// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/viewer/live_messages.h"
#include "rastro/viewer/scene.h"

namespace rastro {

struct ViewServerOptions {
  /// Numeric, IPv4 or IPv6. Any but a loopback address needs a token.
  std::string address = "127.0.0.1";
  /// 0: any free one; nullopt: 8420, or any free one where that is taken.
  std::optional<std::uint16_t> port;
  /// Letters, digits, '-' and '_'; what a client must know. Empty: none is asked for.
  std::string token;
  int max_connections = 64;       ///< At a time; a new one ends the oldest one that waits for a request.
  double request_seconds = 10.0;  ///< A connection without a whole request for so long is closed.
};

/// Serves the page and scenes over HTTP from a thread of its own, from the constructor to stop(). GET and HEAD of '/',
/// '/api/scenes' (JSON: index, name and bytes of each) and '/api/scene/N'. Everything else is refused, as are requests
/// for another host (DNS rebinding), of another origin, without the token, with a body, or with more than 8 KiB of
/// headers. No part of a request ever names a file.
class ViewServer {
 public:
  /// Error for an address that is none or cannot be listened on, a taken port, a token of other letters, or an address
  /// other machines can reach without a token.
  ViewServer(ViewServerOptions options, std::vector<NamedScene> scenes);
  /// Of a run that goes on: a WebSocket at '/live' gives its messages, and takes commands; scene 0 is its map, none at
  /// first. What is sent never waits for a client: slow ones miss frames, and are told how many.
  ViewServer(const LiveHello& run, ViewServerOptions options);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  std::uint16_t port() const;
  /// Of the page, with the token.
  std::string url() const;

  // Of a run that goes on. From any thread.
  void send(const LiveFrame& frame);
  void send(const LiveImage& image);
  void send(const LivePlace& place);
  void send(const LiveStatus& status);
  void send(const LiveCalibration& calibration);
  void set_scene(NamedScene scene, std::int64_t revision);
  /// The run began another map: until the next set_scene() it has none, as at first.
  void forget_scene(std::string name);
  int clients() const;  ///< Pages that watch.
  /// What a page asked for, the oldest first; waits for it at most so long.
  std::optional<LiveCommand> next_command(std::chrono::milliseconds at_most);

  /// Ends all connections, at once. Can be called from any thread, and again.
  void stop();

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

/// 32 hexadecimal digits from the system's source of randomness.
std::string random_token();

}  // namespace rastro
