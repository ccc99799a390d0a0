// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/live.h"

#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/dataset/live/freenect.h"
#include "rastro/dataset/live/openni2.h"
#include "rastro/dataset/live/pipe.h"
#include "rastro/dataset/live/stream.h"
#include "rastro/dataset/live/v4l2.h"
#include "rastro/dataset/registered_depth.h"

namespace rastro {
namespace {

struct Request {
  std::string address;  ///< In full.
  std::string rest;     ///< Behind the scheme.
  const OpenOptions& options;
  const ReplayOptions& replay;
  Clock& clock;
  const std::atomic<bool>* stop;
};

std::unique_ptr<LiveSource> open_replay(const Request& request) {
  if (request.rest.empty()) throw Error("names no recording", request.address, "give replay:DATA");
  return make_replay([data = request.rest, options = request.options] { return open(data, options); }, request.replay,
                     request.clock);
}

std::unique_ptr<LiveSource> open_camera(const Request& request) {
  return open_v4l2(request.address, request.rest, request.options, v4l2_system(), request.clock);
}

std::unique_ptr<LiveSource> open_depth_camera(const Request& request) {
  return registered_depth(open_openni2(request.address, request.rest, request.options, request.clock), request.options);
}

std::unique_ptr<LiveSource> open_network(const Request& request) {
  return open_stream(request.address, request.options, request.clock);
}

std::unique_ptr<LiveSource> open_standard_input(const Request& request) {
  if (!request.rest.empty()) throw Error("reads standard input only", request.address, "give pipe:");
  return open_pipe(request.address, STDIN_FILENO, request.options, request.clock, request.stop);
}

std::unique_ptr<LiveSource> open_kinect(const Request& request) {
  return registered_depth(
      open_freenect(request.address, request.rest, request.options, freenect_system(), request.clock), request.options);
}

struct Scheme {
  std::string_view begin;
  std::unique_ptr<LiveSource> (*open)(const Request&);
};

constexpr Scheme schemes[] = {
    {"replay:", open_replay},   {"v4l2:", open_camera},    {"openni2:", open_depth_camera}, {"http://", open_network},
    {"https://", open_network}, {"rtsp://", open_network}, {"pipe:", open_standard_input},  {"freenect:", open_kinect}};

const Scheme* scheme_of(const std::string& address) {
  const auto* found = std::find_if(std::begin(schemes), std::end(schemes),
                                   [&](const Scheme& each) { return address.starts_with(each.begin); });
  return found == std::end(schemes) ? nullptr : found;
}

}  // namespace

const char* const live_forms =
    "replay:DATA, v4l2:/dev/video0[,1280x720@30], openni2:[FILE.oni], freenect:0, http://..., rtsp://... or pipe:";

bool is_live(const std::string& address) { return scheme_of(address) != nullptr; }

std::unique_ptr<LiveSource> open_live(const std::string& address, const OpenOptions& options,
                                      const ReplayOptions& replay, Clock& clock, const std::atomic<bool>* stop) {
  const Scheme* scheme = scheme_of(address);
  if (!scheme) throw Error("is not a live source", address, std::string("give ") + live_forms);
  return scheme->open({address, address.substr(scheme->begin.size()), options, replay, clock, stop});
}

}  // namespace rastro
