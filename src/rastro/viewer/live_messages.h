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

enum class LiveCommand : std::uint8_t { pause, resume, step, mapping_on, mapping_off, reset, save, end };

const char* name_of(LiveCommand command);  ///< "pause", ...
/// Of a client's message, {"command":"pause"}; nullopt for anything else.
std::optional<LiveCommand> live_command_in(std::string_view message);

/// What the run is.
struct LiveHello {
  std::string title, method;
  std::optional<std::int64_t> frames;         ///< In all, if known.
  std::vector<LiveCommand> commands;          ///< Those that it understands.
  bool has_poses = true;                      ///< False: there is nothing to see but images.
  std::vector<std::string> state_names = {};  ///< Of its frames; empty: scene_state_names().
};

/// One frame as the method reported it.
struct LiveFrame {
  std::int64_t index = 0;  ///< In the recording.
  double stamp_s = 0.0;
  std::size_t state = 0;               ///< Index into the names of LiveHello.
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
  int resets = 0;    ///< How often the run began anew: frames before the last time are of another map.
};

/// The features of an image. An array but the first two may be empty: unknown.
struct LiveFeatures {
  std::vector<float> pixels;                ///< x and y of each.
  std::vector<std::uint8_t> states;         ///< Of each; index into `state_names`.
  std::vector<std::int32_t> ids;            ///< Of each, the same in all frames; -1: none.
  std::vector<std::uint8_t> trail_lengths;  ///< Of each: how many pixels of `trails` are its own.
  std::vector<float> trails;                ///< x and y where it was in the last frames, the oldest first.
  std::vector<std::uint8_t> colors;         ///< Of each: red, green, blue; else each state has its own.
  std::vector<std::string> state_names;
};

/// An image with the features found in it.
struct LiveImage {
  std::int64_t index = 0;
  int width = 0, height = 0;       ///< Pixels of the whole image, that the features refer to.
  std::vector<std::uint8_t> jpeg;  ///< May be smaller.
  LiveFeatures features;
};

/// A keyframe as the map knows it, and the earlier one that it was matched with.
struct LivePlace {
  LiveImage image;             ///< Its features in the colors of the method.
  std::int64_t keyframe = -1;  ///< -1: a frame that is none.
  std::optional<LiveImage> matched_image;
  std::int64_t matched = -1;
};

/// What the boards seen so far show to a camera that is being calibrated.
struct LiveCoverage {
  std::string camera;                 ///< "left"; empty where there is one.
  std::vector<std::uint8_t> seen;     ///< Of cells of the image, as many along a row as rows: 1 has a corner.
  std::vector<std::uint8_t> missing;  ///< Of larger parts, likewise: 1 is where the board is wanted.
  std::vector<double> tilts_deg;      ///< Largest so far: left, right, up, down.
};

/// A calibration that goes on. Images of a pair are side by side in one.
struct LiveCalibration {
  std::string line;                 ///< What to do next, for the person with the board.
  int views = 0, enough_views = 0;  ///< Taken; as many are wanted at least.
  bool enough = false;
  double wanted_tilt_deg = 0.0;
  std::vector<std::string> missing;  ///< In words.
  std::vector<LiveCoverage> cameras;
  std::vector<std::vector<float>> outlines;  ///< Of the boards taken: x and y of their corners, pixels of the image.
};

std::string message_of(const LiveHello& hello);
std::string message_of(const LiveCalibration& calibration);
/// Without its end: each client's own ",\"dropped\":N}" follows.
std::string message_of(const LiveFrame& frame);
std::string message_of(const LiveStatus& status);
std::string scene_message(std::int64_t revision);
std::string block_of(const LiveImage& image);
std::string block_of(const LivePlace& place);

}  // namespace rastro
