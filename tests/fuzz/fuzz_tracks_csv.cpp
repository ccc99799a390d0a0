// SPDX-License-Identifier: Apache-2.0
// tracks.csv and tracks.yaml: either an Error of one line, or a table in order whose counts fit its features.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/export/tracks_csv.h"
#include "rastro/export/tracks_yaml.h"

namespace {

void expect(bool promise) {
  if (!promise) std::abort();
}

void expect_in_order(const rastro::TrackTable& table) {
  std::int64_t last_index = -1;
  for (const rastro::TrackFrame& frame : table.frames) {
    expect(frame.index > last_index);
    last_index = frame.index;
    expect(frame.tracked + frame.fresh + frame.reidentified == static_cast<int>(frame.features.size()));
    std::int64_t last_id = -1;
    for (const rastro::TrackedFeature& feature : frame.features) {
      expect(feature.id > last_id && feature.age > 0);
      last_id = feature.id;
    }
  }
}

template <typename Parse>
void expect_table_or_line(const Parse& parse, std::string_view text) {
  try {
    expect_in_order(parse(text, "fuzz"));
  } catch (const rastro::Error& error) {
    expect(std::string(error.what()).find('\n') == std::string::npos);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  expect_table_or_line(rastro::parse_tracks_csv, text);
  expect_table_or_line(rastro::parse_tracks_yaml, text);
  return 0;
}
