// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/paper_front_end.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/base/task_pool.h"
#include "rastro/base/text.h"
#include "rastro/cli/interrupt.h"
#include "rastro/dataset/open.h"
#include "rastro/track/options.h"
#include "rastro/track/tracker.h"

namespace rastro::cli {
namespace {

struct TrackerChoice {
  const char* name;
  const char* words;  ///< Of 'rastro track'.
};
constexpr TrackerChoice trackers[] = {{"klt", "--mode klt"}, {"paper", "--preset paper"}, {"default", ""}};

/// The means of Table I, over its frames 21 to 30.
const std::vector<std::string> published = {"the paper's, MH_01", "125.5", "12.7", "51.12", "28.55", ""};

TrackOptions options_of(const std::string& tracker) {
  TrackOptions options;
  if (tracker == "klt") options.mode = "klt";
  if (tracker == "paper") set_paper_preset(options);
  return options;
}

TrackTableMeans tracked_means(const std::string& recording, const OpenOptions& open, const TrackOptions& options,
                              TaskPool& pool) {
  const auto source = rastro::open(recording, open);
  if (!source->info().has_image) throw Error("has no images", recording, "");
  std::optional<Camera> camera;
  if (!source->info().cameras.empty()) camera = source->info().cameras.front().camera;
  Tracker tracker(options, camera, &pool);
  TrackTableMeans means;
  while (const auto frame = source->next()) {
    stop_if_interrupted();
    means.add(tracker.process(frame->image.view(), frame->stamp));
  }
  return means;
}

/// Behind 'rastro track RECORDING': a world knows its camera.
std::vector<std::string> track_flags_of(const CompareInput& input) {
  std::vector<std::string> flags = input.is_world() ? std::vector<std::string>() : input.flags;
  if (!input.frames().empty()) flags.insert(flags.end(), {"--frames", input.frames()});
  return flags;
}

std::string command_of(const std::string& recording, const TrackerChoice& tracker,
                       const std::vector<std::string>& flags) {
  std::string command = "rastro track " + as_shell_word(recording);
  if (*tracker.words != '\0') command += fmt::format(" {}", tracker.words);
  for (const std::string& flag : flags) command += " " + as_shell_word(flag);
  return command + " --out DIR";
}

std::vector<std::string> row_of(const FrontEndFigures& each) {
  const auto percent = each.means.reidentified_percent();
  return {each.tracker,
          fmt::format("{:.1f}", each.means.tracked()),
          fmt::format("{:.1f}", each.means.reidentified()),
          percent ? fmt::format("{:.2f}", *percent) : "-",
          fmt::format("{:.2f}", each.means.time_ms()),
          each.command};
}

}  // namespace

std::vector<FrontEndFigures> front_end_figures(const std::vector<CompareInput>& inputs,
                                               const std::vector<std::string>& recordings) {
  std::vector<FrontEndFigures> figures;
  TaskPool pool(0);
  for (std::size_t input = 0; input < inputs.size(); ++input) {
    if (!inputs[input].facts.has_image || inputs[input].facts.has_depth) continue;
    const std::vector<std::string> flags = track_flags_of(inputs[input]);
    for (const TrackerChoice& tracker : trackers) {
      try {
        const OpenOptions open = open_options_of(recordings[input], flags);
        const auto means = tracked_means(recordings[input], open, options_of(tracker.name), pool);
        figures.push_back({input, tracker.name, means, command_of(recordings[input], tracker, flags)});
      } catch (const Error&) {
        break;  // the runs of the methods say what is wrong with it
      }
    }
  }
  return figures;
}

std::vector<PaperTable> paper_front_end_tables(const Comparison& comparison) {
  std::vector<PaperTable> tables;
  for (std::size_t input = 0; input < comparison.inputs.size(); ++input) {
    PaperTable table;
    table.title = fmt::format("The front-end paper's table I, means: {}", comparison.inputs[input].name);
    table.rows = {{"tracker", "KLT", "# re-identified", "% re-identified", "ms", "command"}};
    for (const FrontEndFigures& each : comparison.front_end)
      if (each.input == input) table.rows.push_back(row_of(each));
    if (table.rows.size() == 1) continue;
    table.rows.push_back(published);
    table.note =
        "Means over the frames in which a feature was lost; the paper's over frames 21 to 30 of MH_01, after an "
        "occlusion: 'rastro compare --paper \"MH_01_easy --frames 0:31\"' tracks the same.";
    tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace rastro::cli
