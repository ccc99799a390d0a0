// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "rastro/base/clock.h"
#include "rastro/dataset/live/replay.h"
#include "rastro/dataset/open.h"
#include "rastro/sensor/live_source.h"

namespace rastro {

/// Their forms in one line, for help and messages.
extern const char* const live_forms;

/// Whether `address` names a live source rather than a recording: it begins with "replay:" or another of their schemes.
bool is_live(const std::string& address);

/// Opens a live source by its address. Throws Error where it cannot be opened, where the build cannot, and for an
/// address that is malformed. `clock` outlives it. Where `stop` is set, waiting for a first image ends, with Error.
///
///     replay:DATA                        any recording at its own pace, or at `replay.speed` times that
///     v4l2:/dev/video0[,1280x720@30]     a camera of Video4Linux2
///     openni2:[FILE.oni]                 a depth camera through OpenNI2, or a recording of one
///     freenect:[0]                       a Kinect 1 through libfreenect
///     http://... https://... rtsp://...  MJPEG or a stream that FFmpeg knows
///     pipe:                              Y4M or MJPEG on standard input
std::unique_ptr<LiveSource> open_live(const std::string& address, const OpenOptions& options,
                                      const ReplayOptions& replay, Clock& clock,
                                      const std::atomic<bool>* stop = nullptr);

}  // namespace rastro
