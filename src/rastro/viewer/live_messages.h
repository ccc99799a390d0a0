// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

// What a run that goes on tells the page, and what the page asks of it: the messages of /live, see README.md.

enum class LiveCommand : std::uint8_t { pause, resume, step, mapping_on, mapping_off, end };

const char* name_of(LiveCommand command);  ///< "pause", ...
/// Of a client's message, {"command":"pause"}; nullopt for anything else.
std::optional<LiveCommand> live_command_in(std::string_view message);

/// What the run is.
struct LiveHello {
  std::string title, method;
  std::optional<std::int64_t> frames;  ///< In all, if known.
  std::vector<LiveCommand> commands;   ///< Those that it understands.
};

/// One frame as the method reported it.
struct LiveFrame {
  std::int64_t index = 0;  ///< In the recording.
  double stamp_s = 0.0;
  std::size_t state = 0;               ///< Index into scene_state_names().
  std::string reason, detail, advice;  ///< Empty: none.
  std::optional<SE3> world_from_body;  ///< As first estimated.
  std::optional<double> sigma;         ///< Of the position: root of the covariance's trace.
  int used = 0;
  double score = 0.0;
  double milliseconds = 0.0;
  std::vector<std::pair<std::string, double>> stages;       ///< Milliseconds of each.
  std::vector<std::pair<std::string, std::string>> events;  ///< Kind and detail.
  std::int64_t done = 0;                                    ///< Frames so far.
  double rate_hz = 0.0, memory_mb = 0.0;
};

struct LiveStatus {
  bool paused = false;
  std::optional<bool> mapping;  ///< nullopt: the method cannot tell.
  bool ended = false;
  std::string line;  ///< For a person.
};

/// An image with the features found in it.
struct LiveImage {
  std::int64_t index = 0;
  int width = 0, height = 0;         ///< Pixels of the whole image, that `features` refer to.
  std::vector<std::uint8_t> jpeg;    ///< May be smaller.
  std::vector<float> features;       ///< x and y of each.
  std::vector<std::uint8_t> states;  ///< Of each; index into live_feature_state_names().
};

/// "unmatched", "matched", "outlier", "inlier", "new".
const std::vector<std::string>& live_feature_state_names();

std::string message_of(const LiveHello& hello);
/// Without its end: each client's own ",\"dropped\":N}" follows.
std::string message_of(const LiveFrame& frame);
std::string message_of(const LiveStatus& status);
std::string scene_message(std::int64_t revision);
std::string block_of(const LiveImage& image);

}  // namespace rastro
