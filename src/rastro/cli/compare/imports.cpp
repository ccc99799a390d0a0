// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/imports.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/benchmark/run_scores.h"
#include "rastro/cli/compare/map_figures.h"
#include "rastro/cli/compare/run_trace.h"
#include "rastro/export/ply.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* flag = "--import";

std::size_t input_of(const Import& import, const std::vector<CompareInput>& inputs) {
  if (import.input.empty() && inputs.size() == 1) return 0;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    if (inputs[k].name == import.input) return k;
    names.push_back(inputs[k].name);
  }
  if (import.input.empty())
    throw Error(fmt::format("'{}' does not say of which input it is", import.name), flag,
                fmt::format("give {}@{}=...", import.name, names.front()));
  throw Error(in_quotes(import.input) + " is not an input", flag, did_you_mean(import.input, names));
}

void require_alignment(const std::string& name) {
  try {
    parse_alignment(name);
  } catch (const Error&) {
    throw Error(in_quotes(name) + " is not an alignment, a .ply file or 'body'", flag,
                "give none, se3, sim3, yaw or origin");
  }
}

/// What the numbers of the table do not show.
void warn_about(const Import& import, const RunTrace& trace) {
  constexpr std::size_t few = 10;
  const std::size_t matched = trace.scores.pairs.size();
  if (matched < few)
    log_warning(fmt::format("{}: only {} matched: an alignment makes the error of so few small, whatever they are",
                            one_line(import.trajectory), matched == 1 ? "1 pose" : fmt::format("{} poses", matched)));
  const bool is_converted = !import.of_body && trace.reference->frames.find("T_BS") != std::string::npos;
  if (is_converted)
    log_warning(
        fmt::format("{}: its poses are taken as the camera's, those of the ground truth are converted from the "
                    "body; where they are the body's, give {}=...,body",
                    one_line(import.trajectory), import.name));
}

RunTrace read_trace(const Import& import, const std::string& recording, const std::string& frames) {
  TraceReader reader;
  auto trace = reader.read(import.trajectory, recording, import.alignment, frames, import.of_body);
  if (!trace)
    throw Error("no pose matches the ground truth of the input", import.trajectory,
                "are its timestamps those of the recording?");
  const std::size_t poses = trace->estimate.poses.size(), of_truth = trace->reference->input.poses.size();
  if (trace->scores.pairing.by_index && poses != of_truth)
    throw Error(fmt::format("has {} poses without timestamps for {} of the input", poses, of_truth), import.trajectory,
                "put KITTI's times.txt beside it");
  return *trace;
}

/// `frames`: of the input; 0: unknown.
RunFigures figures_of(const Import& import, const RunTrace& trace, const std::string& recording, std::int64_t frames) {
  RunFigures figures;
  add_trajectory_figures(trace.scores, trace.reference->input, import.alignment == "se3", figures);
  figures["completion_percent"] = trace.posed_percent(frames);
  if (import.cloud.empty()) return figures;
  // Surfaces are in the camera of the recording's first frame, whatever part of it is compared.
  const SE3 world_from_first_camera = read_reference(poses_beside(recording), {}).input.poses.front().world_from_body;
  const Sim3 first_camera_from_world(1.0, world_from_first_camera.inverse().rotation(),
                                     world_from_first_camera.inverse().translation());
  add_surface_figures(read_cloud_ply(import.cloud), first_camera_from_world * trace.scores.reference_from_estimate,
                      recording, figures);
  return figures;
}

}  // namespace

Import parse_import(const std::string& text) {
  const std::size_t equals = text.find('=');
  const auto pieces = split(std::string_view(text).substr(std::min(text.size(), equals + 1)), ',');
  if (equals == std::string::npos || equals == 0 || pieces.front().empty())
    throw Error(in_quotes(text) + " is not an import", flag, "give NAME=trajectory.txt[,cloud.ply][,sim3]");
  Import import;
  import.name = text.substr(0, equals);
  if (const std::size_t at = import.name.find('@'); at != std::string::npos)
    import.input = import.name.substr(at + 1), import.name.resize(at);
  import.trajectory = pieces.front();
  for (std::size_t k = 1; k < pieces.size(); ++k) {
    const std::string piece(pieces[k]);
    if (piece == "body")
      import.of_body = true;
    else
      (fs::path(piece).extension() == ".ply" ? import.cloud : import.alignment) = piece;
  }
  require_alignment(import.alignment);
  for (const std::string& file : {import.trajectory, import.cloud}) {
    std::error_code ignored;
    if (!file.empty() && !fs::exists(file, ignored)) throw Error("no such file", file, "correct --import");
  }
  return import;
}

std::vector<ScoredImport> score_imports(const std::vector<Import>& imports, const std::vector<CompareInput>& inputs,
                                        const std::vector<std::string>& recordings,
                                        const std::vector<std::string>& columns) {
  std::vector<ScoredImport> all;
  std::set<std::pair<std::size_t, std::string>> taken;
  for (const Import& import : imports) {
    const std::size_t input = input_of(import, inputs);
    const bool is_method = std::find(columns.begin(), columns.end(), import.name) != columns.end();
    if (is_method || !taken.insert({input, import.name}).second)
      throw Error(fmt::format("'{}' is the name of another column", one_line(import.name)), flag,
                  "choose another name");
    const std::string &recording = recordings[input], frames = inputs[input].frames();
    const std::uint64_t seed = inputs[input].seeds.empty() ? 0 : inputs[input].seeds.front();
    const RunTrace trace = read_trace(import, recording, frames);
    warn_about(import, trace);
    std::string command = fmt::format("rastro evaluate trajectory {} {} --align {}", as_shell_word(recording),
                                      as_shell_word(import.trajectory), import.alignment);
    if (import.of_body) command += " --estimate-of body";
    if (!frames.empty()) command += " --frames " + frames;
    all.push_back(
        {{input, import.name, seed, import.trajectory, recording, import.alignment, std::move(command), import.of_body},
         figures_of(import, trace, recording, inputs[input].facts.frames)});
  }
  return all;
}

void add_imports(const std::vector<ScoredImport>& imports, Comparison& comparison) {
  for (const ScoredImport& import : imports) {
    for (const auto& [figure, value] : import.figures)
      comparison.table.add(comparison.inputs[import.what.input].name, import.what.column, figure,
                           {value, import.what.seed, 1, import.what.command});
    comparison.imported.push_back(import.what);
  }
}

}  // namespace rastro::cli
