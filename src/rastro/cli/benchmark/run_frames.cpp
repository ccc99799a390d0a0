// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/run_frames.h"

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"

namespace rastro::cli {
namespace {

constexpr TimeNs same_stamp_within = 1'000'000;

bool is_tracked_state(const std::string& state) {
  return state == "tracking" || state == "weak" || state == "relocalized";
}

}  // namespace

std::vector<RunFrame> read_run_frames(const std::filesystem::path& stats_csv) {
  std::vector<RunFrame> frames;
  const std::string text = read_text_file(stats_csv.string());
  for (const TextLine& line : content_lines(text)) {
    const auto cells = split(line.text, ',');
    if (cells.size() < 3 || cells[0] == "frame") continue;
    const auto number = parse_int64(cells[0]), stamp = parse_int64(cells[1]);
    if (!number || !stamp)
      throw Error("has no frame number and stamp", at_line(stats_csv.string(), line.number), "run it again");
    RunFrame frame{*number, *stamp, false, std::string(cells[2]), cells.size() > 3 ? std::string(cells[3]) : ""};
    frame.tracked = is_tracked_state(frame.state);
    frames.push_back(std::move(frame));
  }
  return frames;
}

bool was_tracked(const std::vector<RunFrame>& frames, TimeNs stamp) {
  const auto found = std::lower_bound(frames.begin(), frames.end(), stamp - same_stamp_within,
                                      [](const RunFrame& frame, TimeNs first) { return frame.stamp < first; });
  return found != frames.end() && found->stamp <= stamp + same_stamp_within && found->tracked;
}

}  // namespace rastro::cli
