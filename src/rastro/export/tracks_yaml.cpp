// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/tracks_yaml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/export/feature_text.h"

namespace rastro {
namespace {

constexpr std::string_view frame_key = "  - frame: ";
constexpr std::string_view feature_front = "      - [";

std::string yaml_scalar(const std::string& value) {
  const bool word = !value.empty() && value.find_first_not_of(
                                          "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_") == std::string::npos;
  if (word || parse_finite(value)) return value;
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "\"";
}

std::string camera_text(const std::optional<Camera>& camera) {
  if (!camera) return "camera: {}  # no calibration: ray_x and ray_y are .nan\n";
  const char* model = camera->distortion == Distortion::none                ? "none"
                      : camera->distortion == Distortion::radial_tangential ? "radial_tangential"
                      : camera->distortion == Distortion::rational          ? "rational"
                                                                            : "equidistant";
  const std::vector<double> coefficients(
      camera->coefficients.begin(), camera->coefficients.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(
                                                                       5, camera->coefficient_count())));
  return fmt::format(
      "camera:\n  width: {}\n  height: {}\n  fx_px: {}\n  fy_px: {}\n  cx_px: {}\n  cy_px: {}\n  distortion: {}\n"
      "  coefficients: [{}]\n",
      camera->width, camera->height, camera->fx, camera->fy, camera->cx, camera->cy, model,
      fmt::join(coefficients, ", "));
}

std::string header_text(const TracksHeader& header) {
  std::string text =
      "%YAML 1.1\n---\nformat: rastro_tracks\nversion: 1\n"
      "# One row per feature: id (given once, kept over occlusions); pixel in the image as given; undistorted\n"
      "# normalized ray (x/z, y/z); frames in which the id was seen so far; state: tracked, new or reidentified;\n"
      "# frame in which the id was seen before this one (-1: never). Frames are numbered as in the recording.\n";
  text += fmt::format("columns: [{}]\n", fmt::join(feature_columns, ", "));
  text += camera_text(header.camera);
  text += header.options.empty() ? "options: {}\n" : "options:\n";
  for (const auto& [name, value] : header.options) text += fmt::format("  {}: {}\n", name, yaml_scalar(value));
  return text + "frames:\n";
}

std::string frame_text(const TrackFrame& frame) {
  std::string text = fmt::format(
      "{}{}\n    stamp_ns: \"{}\"\n    tracked: {}\n    reidentified: {}\n    new: {}\n    lost: {}\n    masked: {}\n"
      "    health: {}\n    features:{}\n",
      frame_key, frame.index, frame.stamp, frame.tracked, frame.reidentified, frame.fresh, frame.lost, frame.masked,
      name_of(frame.health), frame.features.empty() ? " []" : "");
  for (const TrackedFeature& feature : frame.features) {
    text += feature_front;
    append_feature(text, feature, ", ", ".nan");
    text += "]\n";
  }
  return text;
}

/// Reads the lines of frames; knows only the form that frame_text() writes.
class Reader {
 public:
  explicit Reader(std::string_view where) : where_(where) {}

  void read_line(std::string_view line) {
    ++line_number_;
    if (line.starts_with(frame_key)) {
      begin_frame(line.substr(frame_key.size()));
    } else if (next_key_ < keys.size()) {
      read_key(line);
    } else {
      read_feature(line);
    }
  }

  TrackTable finish() {
    if (!table_.frames.empty() && !whole()) table_.frames.pop_back();
    return std::move(table_);
  }
  void skip_line() { ++line_number_; }

 private:
  static constexpr std::array<std::string_view, 8> keys = {"stamp_ns", "tracked", "reidentified", "new",
                                                           "lost",     "masked",  "health",       "features"};

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(what, fmt::format("{}:{}", where_, line_number_), "give a tracks.yaml as 'rastro track' writes it");
  }

  bool whole() const {
    const TrackFrame& frame = table_.frames.back();
    return next_key_ == keys.size() && expected_ == static_cast<std::int64_t>(frame.features.size());
  }

  void begin_frame(std::string_view number) {
    if (!table_.frames.empty() && !whole()) fail("the previous frame is incomplete");
    const auto index = parse_int64(number);
    if (!index || *index < 0) fail("a frame needs a number");
    if (!table_.frames.empty() && *index <= table_.frames.back().index) fail("frames are not in ascending order");
    table_.frames.emplace_back().index = *index;
    next_key_ = 0;
    expected_ = 0;
  }

  void read_key(std::string_view line) {
    const auto colon = line.find(':');
    const std::string_view key = trim(line.substr(0, colon));
    if (table_.frames.empty() || colon == std::string_view::npos || key != keys[next_key_]) {
      fail(fmt::format("'{}' is expected here", table_.frames.empty() ? "frame" : keys[next_key_]));
    }
    set_key(trim(line.substr(colon + 1)));
    ++next_key_;
  }

  void set_key(std::string_view value) {
    TrackFrame& frame = table_.frames.back();
    if (next_key_ == 7) return;  // "features:" itself
    if (next_key_ == 6) {
      const auto health = parse_health(value);
      if (!health) fail("'health' is not a known name");
      frame.health = *health;
      return;
    }
    const bool quoted = value.size() > 1 && value.front() == '"' && value.back() == '"';
    const auto number = parse_int64(quoted ? value.substr(1, value.size() - 2) : value);
    if (!number || (next_key_ > 0 && (*number < 0 || *number > 100'000'000))) {
      fail(fmt::format("'{}' is not a number in its range", keys[next_key_]));
    }
    if (next_key_ == 0) frame.stamp = *number;
    if (next_key_ >= 1 && next_key_ <= 3) expected_ += *number;
    if (next_key_ == 4) frame.lost = static_cast<int>(*number);
    if (next_key_ == 5) frame.masked = static_cast<int>(*number);
  }

  void read_feature(std::string_view line) {
    if (!line.starts_with(feature_front) || !line.ends_with(']')) fail("a feature in [...] is expected here");
    line.remove_prefix(feature_front.size());
    line.remove_suffix(1);
    const auto feature = parse_feature(split(line, ','));
    if (!feature) fail("not a feature [id, x_px, y_px, ray_x, ray_y, age, state, last_seen]");
    TrackFrame& frame = table_.frames.back();
    if (!frame.features.empty() && feature->id <= frame.features.back().id) fail("ids are not in ascending order");
    add_feature(frame, *feature);
  }

  std::string_view where_;
  TrackTable table_;
  int line_number_ = 0;
  std::size_t next_key_ = 0;   ///< Which of `keys` comes next in the last frame.
  std::int64_t expected_ = 0;  ///< Features that the last frame's counts promise.
};

}  // namespace

TracksYaml::TracksYaml(const std::filesystem::path& path, const TracksHeader& header) : file_(path) {
  file_.append(header_text(header));
}

void TracksYaml::write(const TrackFrame& frame, GrayView) { file_.append(frame_text(frame)); }

TrackTable parse_tracks_yaml(std::string_view text, std::string_view where) {
  constexpr std::string_view any_version = "%YAML 1.";  // files of before say 1.0, which libyaml rejects
  constexpr std::string_view rest = "\n---\nformat: rastro_tracks\nversion: 1\n";
  if (!text.starts_with(any_version) || text.find(rest) != any_version.size() + 1) {
    throw Error("is not a tracks.yaml of version 1", fmt::format("{}:1", where),
                "give a tracks.yaml as 'rastro track' writes it");
  }
  Reader reader(where);
  bool in_frames = false;
  for (auto end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    if (in_frames) {
      reader.read_line(line);
    } else {
      reader.skip_line();
      in_frames = line == "frames:";
    }
  }
  return reader.finish();
}

}  // namespace rastro
