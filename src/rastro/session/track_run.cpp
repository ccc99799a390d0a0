// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/track_run.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/memory.h"
#include "rastro/session/frame_numbers.h"
#include "rastro/session/frame_reader.h"
#include "rastro/session/time_histogram.h"
#include "rastro/session/writer_thread.h"

namespace rastro {
namespace {

constexpr std::size_t images_waiting = 4;
class Runner {
 public:
  explicit Runner(const TrackRun& run)
      : run_(run), reader_(*run.source, run.folder), writer_(run.image_sinks, images_waiting) {
    if (run.live) run.live->set_folder(run.folder);
  }

  TrackRunEnd run_to_the_end() {
    try {
      process_all();
    } catch (const Error& error) {
      end_.failure = std::current_exception();
      end_.result.ended = error.what();
    } catch (const std::exception& error) {
      end_.failure = std::current_exception();
      end_.result.ended = fmt::format("fault: {}", error.what());
    }
    finish_sinks();
    sum_up();
    return std::move(end_);
  }

 private:
  void process_all() {
    for (;;) {
      if (run_.stop && run_.stop->load()) {
        end_.result.interrupted = true;
        end_.result.ended = "interrupted";
        return;
      }
      std::optional<Frame> frame = reader_.next();
      if (!frame) break;
      process(*frame);
    }
    end_.result.interrupted = run_.live && run_.live->was_stopped();
    end_.result.ended = end_.result.interrupted ? "interrupted" : "end of data";
  }

  void process(Frame& frame) {
    const GrayView mask = run_.mask_of ? run_.mask_of(frame) : GrayView{};
    const auto begin = std::chrono::steady_clock::now();
    TrackFrame tracks = run_.process(frame.image, frame.stamp, mask);
    tracks.times.total_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    if (run_.live) run_.live->note_pose();
    times_.add(tracks.times.total_ms);
    renumber(tracks, frame.index);
    count(tracks);
    for (TrackSink* sink : run_.sinks) sink->write(tracks, frame.image);
    if (run_.folder) write_to_folder(tracks);
    if (run_.progress) report(tracks);
    writer_.write(std::move(tracks), std::move(frame.image));
  }

  /// The tracker counts the frames it gets; users count the frames of the recording.
  void renumber(TrackFrame& tracks, std::int64_t recorded) {
    numbers_.add(recorded);
    tracks.index = recorded;
    for (TrackedFeature& feature : tracks.features) feature.last_seen = numbers_.recorded(feature.last_seen);
  }

  void count(const TrackFrame& tracks) {
    TrackResult& result = end_.result;
    ++result.frames;
    result.features += tracks.fresh;
    result.observations += static_cast<std::int64_t>(tracks.features.size());
    result.tracked += tracks.tracked;
    result.reidentified += tracks.reidentified;
    result.lost += tracks.lost;
    result.masked += tracks.masked;
    result.unhealthy_frames += tracks.health == TrackHealth::good ? 0 : 1;
  }

  void write_to_folder(const TrackFrame& tracks) {
    run_.folder->add_stats(tracks);
    if (tracks.health != health_) {
      const std::string text = tracks.health == TrackHealth::good
                                   ? "good again"
                                   : fmt::format("{}: {} features", name_of(tracks.health), tracks.features.size());
      run_.folder->add_event(tracks.index, "health", text);
    }
    health_ = tracks.health;
  }

  void report(const TrackFrame& tracks) {
    run_.progress({end_.result.frames + reader_.skipped(), run_.frames_asked, &tracks, times_.mean_ms()});
  }

  /// The first failure is reported; a sink that fails here must not keep the others from finishing.
  void finish_sinks() {
    const auto attempt = [this](const auto& action) {
      try {
        action();
      } catch (...) {
        if (!end_.failure) end_.failure = std::current_exception();
      }
    };
    for (TrackSink* sink : run_.sinks) attempt([sink] { sink->finish(); });
    attempt([this] { writer_.finish(); });
  }

  void sum_up() {
    TrackResult& result = end_.result;
    result.skipped_frames = reader_.skipped();
    end_.first_skip = reader_.first_skip();
    if (run_.live) result.live = run_.live->statistics();
    const std::int64_t dropped = result.live ? result.live->dropped : 0;
    const std::int64_t asked = run_.frames_asked.value_or(result.frames + result.skipped_frames + dropped);
    result.coverage = asked > 0 ? 100.0 * static_cast<double>(result.frames) / static_cast<double>(asked) : 0.0;
    result.ms_per_frame_mean = times_.mean_ms();
    result.ms_per_frame_p95 = times_.percentile_ms(0.95);
    result.peak_memory_mb = peak_resident_memory_mb();
    if (result.features > 0) {
      result.mean_track_length = static_cast<double>(result.observations) / static_cast<double>(result.features);
    }
  }

  const TrackRun& run_;
  FrameReader reader_;
  WriterThread writer_;
  FrameNumbers numbers_;
  TimeHistogram times_;
  TrackRunEnd end_;
  TrackHealth health_ = TrackHealth::good;
};

}  // namespace

TrackRunEnd track_run(const TrackRun& run) {
  RASTRO_CHECK(run.source && run.process, "a run needs a source and a tracker");
  return Runner(run).run_to_the_end();
}

}  // namespace rastro
