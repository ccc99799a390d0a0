// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/tracks_jsonl.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "rastro/base/scratch_testing.h"
#include "rastro/base/text.h"
#include "rastro/export/track_frames_testing.h"

namespace rastro {
namespace {

TEST(TracksJsonl, EveryLineIsAFrame) {
  const auto frames = awkward_frames();
  const auto path = scratch_folder("jsonl") / "tracks.jsonl";
  TracksJsonl file(path);
  for (const TrackFrame& frame : frames) file.write(frame, {});
  const std::string text = read_whole_file(path);
  const auto lines = split(text, '\n');
  ASSERT_EQ(lines.size(), frames.size() + 1) << "each line ends with a line break";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto json = nlohmann::json::parse(lines[i]);
    EXPECT_EQ(json["frame"], frames[i].index);
    EXPECT_EQ(json["stamp_ns"], frames[i].stamp);
    EXPECT_EQ(json["health"], name_of(frames[i].health));
    EXPECT_EQ(json["reidentified"], frames[i].reidentified);
    ASSERT_EQ(json["features"].size(), frames[i].features.size());
    for (std::size_t k = 0; k < frames[i].features.size(); ++k) {
      const TrackedFeature& feature = frames[i].features[k];
      EXPECT_EQ(json["features"][k]["id"], feature.id);
      EXPECT_EQ(json["features"][k]["pixel"][0].get<float>(), feature.pixel.x());
      EXPECT_EQ(json["features"][k]["ray"].is_null(), std::isnan(feature.ray.x()));
      EXPECT_EQ(json["features"][k]["state"], name_of(feature.state));
    }
  }
}

}  // namespace
}  // namespace rastro
