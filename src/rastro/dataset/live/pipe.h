// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "rastro/dataset/live/live_camera.h"

namespace rastro {

/// Y4M or MJPEG from a file descriptor, such as standard input: "pipe:". Told apart by the first bytes, so the first
/// ones are waited for, for at most ten seconds. Stamps are times of arrival, or made up where options.rate_hz is
/// given. The descriptor is the caller's. Error for a stream that is neither, and where `stop` is set meanwhile.
std::unique_ptr<LiveSource> open_pipe(const std::string& address, int descriptor, const OpenOptions& options,
                                      Clock& clock, const std::atomic<bool>* stop = nullptr);

}  // namespace rastro
