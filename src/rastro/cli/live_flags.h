// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>

#include "rastro/cli/run_flags.h"
#include "rastro/dataset/record/recording_writer.h"
#include "rastro/session/frame_recorder.h"
#include "rastro/session/live_input.h"

namespace rastro::cli {

/// --speed, --loop, --queue; what waits in the queue is for `user`: "the method".
void add_live_flags(CLI::App& command, LiveFlags& flags, const char* user = "the method");
/// --record.
void add_record_flag(CLI::App& command, LiveFlags& flags);

/// The source of a run: a recording, or a live one.
struct RunInput {
  std::unique_ptr<RecordingWriter> writer;  ///< Of --record; null without.
  std::unique_ptr<FrameRecorder> recorder;
  std::unique_ptr<Source> source;
  LiveInput* live = nullptr;  ///< `source`, if it is live.
};

/// Opens DATA, disturbed as the flags say where it is a recording. Error for flags of a live source or a replay without
/// one. Ctrl-C ends the frames of a live source. `user` takes the frames, for messages.
RunInput open_run_input(const RunFlags& flags, const OpenOptions& options, const char* user = "the method");

/// --view does what its pages ask for also while a live source gives no frame. `view`: null without --view.
template <typename View>
void watch_while_idle(RunInput& input, View* view) {
  if (input.live && view) input.live->set_idle([view](const LiveCondition& condition) { view->idle(condition.line); });
}

/// After a run: what was recorded joins the statistics. After Ctrl-C it does not take long.
void finish_recording(RunInput& input, std::optional<LiveStatistics>& statistics);

}  // namespace rastro::cli
