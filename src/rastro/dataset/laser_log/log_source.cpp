// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/ground_truth.h"
#include "rastro/dataset/laser_log/log_lines.h"
#include "rastro/dataset/laser_log/log_parser.h"
#include "rastro/dataset/recording.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro {
namespace {

/// groundtruth.txt in the folder of the log: the body's poses, as generated recordings have them.
void read_ground_truth_beside(SourceInfo& info) {
  const auto file = std::filesystem::path(info.path).replace_filename("groundtruth.txt");
  if (!is_file(file)) return;
  read_ground_truth(info, file, "body",
                    [&] { return parse_tum_trajectory(read_text_file(file.string()), file.string()); });
}

class LogSource final : public Source {
 public:
  LogSource(const std::string& path, std::unique_ptr<LogParser> parser, const OpenOptions& options)
      : parser_(std::move(parser)), lines_(path) {
    if (!options.camera.empty()) throw Error("a laser log has no cameras", "--camera", "omit it");
    info_.path = path;
    info_.has_image = false;
    read_all();
    parser_->start_over(info_);
    read_ground_truth_beside(info_);
    choice_ = FrameChoice(options, info_.frame_count, path);
    lines_ = LogLines(path);
  }

  const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (position_ >= choice_.count) return std::nullopt;
    const std::int64_t wanted = choice_.index(position_++);
    while (const auto line = lines_.next()) {
      const LinePosition position{info_.path, lines_.number()};
      try {
        auto frame = parser_->read(*line, position);
        if (!frame || at_++ < wanted) continue;
        frame->index = wanted;
        frame->name = fmt::format("line {}", position.line);
        return frame;
      } catch (const Error&) {
        if (at_++ >= wanted) throw;
      }
    }
    return std::nullopt;
  }

 private:
  void read_all() {
    std::int64_t broken = 0;
    std::string first_problem;
    while (const auto line = lines_.next()) {
      try {
        if (parser_->read(*line, {info_.path, lines_.number()})) ++info_.frame_count;
      } catch (const Error& error) {
        if (broken++ == 0) first_problem = error.what();
        ++info_.frame_count;
      }
    }
    if (lines_.damaged())
      info_.warnings.push_back(fmt::format("the packed file is damaged or breaks off after {} frames, line {}: {}",
                                           info_.frame_count, lines_.number(), info_.path));
    if (lines_.skipped() > 0)
      info_.warnings.push_back(fmt::format("{} damaged lines with control characters are skipped; the first: {}:{}",
                                           lines_.skipped(), info_.path, lines_.first_skipped()));
    if (broken > 0)
      info_.warnings.push_back(
          fmt::format("{} of {} frames cannot be read; the first: {}", broken, info_.frame_count, first_problem));
    if (broken < info_.frame_count) return;
    if (broken > 0)
      throw Error(fmt::format("none of its {} scans can be read; {}", broken, first_problem), info_.path, "");
    throw Error("has no laser scans", info_.path, "the log must have scans of a front laser");
  }

  std::unique_ptr<LogParser> parser_;
  LogLines lines_;
  SourceInfo info_;
  FrameChoice choice_;
  std::int64_t at_ = 0;  ///< Number of the next frame in the file.
  std::int64_t position_ = 0;
};

}  // namespace

std::unique_ptr<Source> make_log_source(const std::string& path, std::unique_ptr<LogParser> parser,
                                        const OpenOptions& options) {
  return std::make_unique<LogSource>(path, std::move(parser), options);
}

}  // namespace rastro
