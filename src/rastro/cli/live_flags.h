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
/// one. Ctrl-C ends the frames of a live source.
RunInput open_run_input(const RunFlags& flags, const OpenOptions& options);

/// After a run: what was recorded joins the statistics.
void finish_recording(RunInput& input, std::optional<LiveStatistics>& statistics);

}  // namespace rastro::cli
