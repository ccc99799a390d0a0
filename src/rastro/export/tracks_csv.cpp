// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/tracks_csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iterator>
#include <span>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/export/feature_text.h"

namespace rastro {
namespace {

constexpr std::size_t columns_of_row = 2 + feature_columns.size() + 4;
constexpr std::string_view no_feature = "-1,nan,nan,nan,nan,0,none,-1";

std::string header_line() {
  return fmt::format("frame,stamp_ns,{},frame_features,frame_lost,frame_masked,frame_health",
                     fmt::join(feature_columns, ","));
}

std::string rows_of(const TrackFrame& frame) {
  const std::string front = fmt::format("{},{},", frame.index, frame.stamp);
  const std::string back =
      fmt::format(",{},{},{},{}\n", frame.features.size(), frame.lost, frame.masked, name_of(frame.health));
  std::string rows;
  for (const TrackedFeature& feature : frame.features) {
    rows += front;
    append_feature(rows, feature, ",", "nan");
    rows += back;
  }
  if (frame.features.empty()) rows = front + std::string(no_feature) + back;
  return rows;
}

/// Reads rows into frames and checks that they fit together.
class Reader {
 public:
  explicit Reader(std::string_view where) : where_(where) {}

  void read_row(std::string_view line) {
    ++line_number_;
    const auto columns = split(line, ',');
    if (columns.size() != columns_of_row) {
      fail(fmt::format("{} columns instead of {}", columns.size(), columns_of_row));
    }
    const TrackFrame row = frame_facts(columns);
    if (table_.frames.empty() || table_.frames.back().index != row.index) begin_frame(row);
    read_feature(std::span(columns).subspan(2, feature_columns.size()), row);
  }

  TrackTable finish() {
    if (!table_.frames.empty() && missing_ > 0) table_.frames.pop_back();  // a run killed while it wrote this frame
    return std::move(table_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(what, fmt::format("{}:{}", where_, line_number_), "give a tracks.csv as 'rastro track' writes it");
  }

  std::int64_t integer(std::string_view text, std::string_view column, std::int64_t lowest) const {
    const auto value = parse_int64(text);
    if (!value || *value < lowest) fail(fmt::format("column '{}' is not a whole number in its range", column));
    return *value;
  }

  int count(std::string_view text, std::string_view column) const {
    const std::int64_t value = integer(text, column, 0);
    if (value > 100'000'000) fail(fmt::format("column '{}' is too large", column));
    return static_cast<int>(value);
  }

  TrackFrame frame_facts(const std::vector<std::string_view>& columns) {
    TrackFrame row;
    row.index = integer(columns[0], "frame", 0);
    row.stamp = integer(columns[1], "stamp_ns", std::numeric_limits<std::int64_t>::min());
    features_ = count(columns[10], "frame_features");
    row.lost = count(columns[11], "frame_lost");
    row.masked = count(columns[12], "frame_masked");
    const auto health = parse_health(columns[13]);
    if (!health) fail("column 'frame_health' is not a known name");
    row.health = *health;
    return row;
  }

  void begin_frame(const TrackFrame& row) {
    if (missing_ > 0) fail(fmt::format("frame {} has fewer rows than its count", table_.frames.back().index));
    if (!table_.frames.empty() && row.index < table_.frames.back().index) fail("frames are not in ascending order");
    table_.frames.push_back(row);
    expected_ = features_;
    missing_ = expected_ > 0 ? expected_ : 1;
  }

  void read_feature(std::span<const std::string_view> columns, const TrackFrame& row) {
    TrackFrame& frame = table_.frames.back();
    if (missing_ == 0) fail(fmt::format("frame {} has more rows than its count", frame.index));
    if (row.stamp != frame.stamp || row.lost != frame.lost || row.masked != frame.masked ||
        row.health != frame.health || features_ != expected_) {
      fail(fmt::format("the rows of frame {} disagree about it", frame.index));
    }
    --missing_;
    if (expected_ == 0) {
      if (columns[0] != "-1" || columns[6] != "none") fail("a frame without features needs a row of state 'none'");
      return;
    }
    const auto feature = parse_feature(columns);
    if (!feature) fail("not a feature (id, x_px, y_px, ray_x, ray_y, age, state, last_seen)");
    if (!frame.features.empty() && feature->id <= frame.features.back().id) fail("ids are not in ascending order");
    add_feature(frame, *feature);
  }

  std::string_view where_;
  TrackTable table_;
  int line_number_ = 1;
  int features_ = 0;  ///< What the row being read says its frame holds.
  int expected_ = 0;  ///< What the first row of the frame said.
  int missing_ = 0;   ///< Rows of the last frame not read yet.
};

}  // namespace

TracksCsv::TracksCsv(const std::optional<std::filesystem::path>& path) {
  if (path) file_.emplace(*path);
  append(header_line() + "\n");
}

void TracksCsv::write(const TrackFrame& frame, GrayView) { append(rows_of(frame)); }

void TracksCsv::append(const std::string& text) {
  hash_.add(text);
  if (file_) file_->append(text);
}

TrackTable parse_tracks_csv(std::string_view text, std::string_view where) {
  const std::string header = header_line() + "\n";
  if (!text.starts_with(header)) {
    throw Error("does not start with the header line of a tracks.csv", fmt::format("{}:1", where),
                "give a tracks.csv as 'rastro track' writes it");
  }
  text.remove_prefix(header.size());
  Reader reader(where);
  // What follows the last line break is a piece of a row that a killed run left.
  for (auto end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
    reader.read_row(text.substr(0, end));
    text.remove_prefix(end + 1);
  }
  return reader.finish();
}

}  // namespace rastro
