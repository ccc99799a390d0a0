// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/tracks_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <opencv2/core/persistence.hpp>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/export/read_tracks.h"
#include "rastro/export/track_frames_testing.h"

namespace rastro {
namespace {

TracksHeader full_header() {
  Camera camera;
  camera.width = 752;
  camera.height = 480;
  camera.fx = 458.654;
  camera.fy = 457.296;
  camera.cx = 367.215;
  camera.cy = 248.375;
  camera.distortion = Distortion::radial_tangential;
  camera.coefficients = {-0.28, 0.07, 0.0002, 1.76e-05, 0.0};
  return {{{"mode", "priority"}, {"features", "150"}, {"min_distance_px", "30"}, {"odd", "a: \"b\" \\ #c"}}, camera};
}

std::filesystem::path write_file(const std::vector<TrackFrame>& frames, const TracksHeader& header,
                                 const std::string& name) {
  const auto folder = scratch_folder("yaml_" + name);
  TracksYaml yaml(folder / "tracks.yaml", header);
  for (const TrackFrame& frame : frames) yaml.write(frame, {});
  yaml.finish();
  return folder / "tracks.yaml";
}

void expect_features(const cv::FileNode& rows, const std::vector<TrackedFeature>& features) {
  ASSERT_EQ(rows.size(), features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    const cv::FileNode row = rows[static_cast<int>(i)];
    const TrackedFeature& feature = features[i];
    EXPECT_EQ(static_cast<int>(row[0]), feature.id);
    EXPECT_EQ(static_cast<float>(row[1]), feature.pixel.x());
    EXPECT_EQ(static_cast<float>(row[2]), feature.pixel.y());
    EXPECT_TRUE(same_float(static_cast<float>(row[3]), feature.ray.x()));
    EXPECT_TRUE(same_float(static_cast<float>(row[4]), feature.ray.y()));
    EXPECT_EQ(static_cast<int>(row[5]), feature.age);
    EXPECT_EQ(static_cast<std::string>(row[6]), name_of(feature.state));
    EXPECT_EQ(static_cast<int>(row[7]), feature.last_seen);
  }
}

TEST(TracksYaml, OpensWithOpenCv) {
  const auto frames = awkward_frames();
  const cv::FileStorage file(write_file(frames, full_header(), "opencv").string(), cv::FileStorage::READ);
  ASSERT_TRUE(file.isOpened());
  EXPECT_EQ(static_cast<std::string>(file["format"]), "rastro_tracks");
  EXPECT_EQ(file["columns"].size(), feature_columns.size());
  EXPECT_EQ(static_cast<double>(file["camera"]["fx_px"]), 458.654);
  EXPECT_EQ(static_cast<std::string>(file["options"]["mode"]), "priority");
  ASSERT_EQ(file["frames"].size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const cv::FileNode frame = file["frames"][static_cast<int>(i)];
    EXPECT_EQ(static_cast<int>(frame["frame"]), frames[i].index);
    EXPECT_EQ(std::stoll(static_cast<std::string>(frame["stamp_ns"])), frames[i].stamp);
    EXPECT_EQ(static_cast<std::string>(frame["health"]), name_of(frames[i].health));
    EXPECT_EQ(static_cast<int>(frame["lost"]), frames[i].lost);
    expect_features(frame["features"], frames[i].features);
  }
}

TEST(TracksYaml, OpensWithYamlCpp) {
  const auto frames = awkward_frames();
  const YAML::Node file = YAML::LoadFile(write_file(frames, full_header(), "yaml_cpp").string());
  EXPECT_EQ(file["options"]["odd"].as<std::string>(), "a: \"b\" \\ #c");
  EXPECT_EQ(file["camera"]["coefficients"][3].as<double>(), 1.76e-05);
  ASSERT_EQ(file["frames"].size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const YAML::Node frame = file["frames"][i];
    EXPECT_EQ(frame["stamp_ns"].as<std::int64_t>(), frames[i].stamp);
    EXPECT_EQ(frame["masked"].as<int>(), frames[i].masked);
    ASSERT_EQ(frame["features"].size(), frames[i].features.size());
    for (std::size_t k = 0; k < frames[i].features.size(); ++k) {
      const YAML::Node row = frame["features"][k];
      EXPECT_EQ(row[0].as<std::int64_t>(), frames[i].features[k].id);
      EXPECT_EQ(row[1].as<float>(), frames[i].features[k].pixel.x());
      EXPECT_TRUE(same_float(row[3].as<float>(), frames[i].features[k].ray.x()));
      EXPECT_EQ(row[6].as<std::string>(), name_of(frames[i].features[k].state));
    }
  }
}

TEST(TracksYaml, WithoutFramesOrCameraItStillOpens) {
  const auto path = write_file({}, {}, "empty");
  EXPECT_TRUE(cv::FileStorage(path.string(), cv::FileStorage::READ).isOpened());
  EXPECT_TRUE(YAML::LoadFile(path.string())["frames"].IsNull());
  EXPECT_TRUE(parse_tracks_yaml(read_whole_file(path), "t").frames.empty());
}

TEST(TracksYaml, ReadsBackWhatItWrote) {
  const auto frames = awkward_frames();
  const TrackTable table = read_tracks(write_file(frames, full_header(), "round_trip"));
  ASSERT_EQ(table.frames.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_TRUE(same_frame(table.frames[i], frames[i])) << "frame " << i;
}

TEST(TracksYaml, SaysAVersionThatLibyamlTakesAndReadsTheOneOfBefore) {
  const auto frames = awkward_frames();
  std::string text = read_whole_file(write_file(frames, full_header(), "version"));
  ASSERT_TRUE(text.starts_with("%YAML 1.1\n---\n"));
  text[8] = '0';
  EXPECT_EQ(parse_tracks_yaml(text, "t").frames.size(), frames.size());
}

TEST(TracksYaml, CutAtAnyByteKeepsTheWholeFrames) {
  const auto frames = awkward_frames();
  const std::string text = read_whole_file(write_file(frames, full_header(), "cut"));
  std::vector<std::size_t> frame_ends;
  for (std::size_t i = 0; i <= frames.size(); ++i) {
    const std::vector<TrackFrame> first(frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(i));
    frame_ends.push_back(read_whole_file(write_file(first, full_header(), "cut_part")).size());
  }
  for (std::size_t cut = frame_ends[0]; cut <= text.size(); ++cut) {
    const TrackTable table = parse_tracks_yaml(std::string_view(text).substr(0, cut), "t.yaml");
    std::size_t whole = 0;
    while (whole < frames.size() && frame_ends[whole + 1] <= cut) ++whole;
    ASSERT_EQ(table.frames.size(), whole) << "cut at " << cut;
    for (std::size_t i = 0; i < whole; ++i) ASSERT_TRUE(same_frame(table.frames[i], frames[i])) << "cut at " << cut;
  }
}

TEST(TracksYaml, NamesTheLineOfWhatIsWrong) {
  const auto path = write_file(awkward_frames(), {}, "damage");
  std::string text = read_whole_file(path);
  text.replace(text.find("reidentified: 0"), 15, "reidentified: x");
  EXPECT_THROW(parse_tracks_yaml(text, "t.yaml"), Error);
  EXPECT_THROW(parse_tracks_yaml("frames:\n", "t.yaml"), Error);
}

TEST(TracksYaml, AHeaderCutOffAnywhereIsRefusedInOneLine) {
  const std::string header = read_whole_file(write_file({}, {}, "header")).substr(0, 40);
  for (std::size_t length = 0; length < 38; ++length)
    EXPECT_THROW(parse_tracks_yaml(header.substr(0, length), "t.yaml"), Error) << length;
}

}  // namespace
}  // namespace rastro
