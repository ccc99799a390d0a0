// SPDX-License-Identifier: Apache-2.0
// Map files of versions 1 and 2, written here row by row as the programs of their time did.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <map>
#include <string>

#include "rastro/base/append_file.h"
#include "rastro/base/hash.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/feature_bytes.h"
#include "rastro/map/file/image_bytes.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/file/recover_map.h"
#include "rastro/map/file/row_parts.h"
#include "rastro/map/images/room_map_testing.h"
#include "rastro/map/landmarks/landmark_map_testing.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

/// Writes rows in the order of the calls.
class OldFile {
 public:
  OldFile(const fs::path& file, std::uint32_t version) : version_(version) {
    EXPECT_EQ(sqlite3_open(file.c_str(), &connection_), SQLITE_OK);
    run("PRAGMA page_size=4096; BEGIN");
    run("PRAGMA application_id=" + std::to_string(map_file_id) + "; PRAGMA user_version=" + std::to_string(version));
    for (const std::string table : tables_of_version(version))
      run("CREATE TABLE " + table + " (id INTEGER PRIMARY KEY, checksum INTEGER NOT NULL, body BLOB NOT NULL)");
  }
  OldFile(const OldFile&) = delete;
  OldFile& operator=(const OldFile&) = delete;
  /// Finishes the file.
  ~OldFile() {
    ByteWriter contents;
    for (const std::string table : tables_of_version(version_)) {
      if (table == "contents") continue;
      contents.put_text(table);
      contents.put(rows_[table]);
      contents.put_text(hashes_[table].finish());
    }
    put("contents", contents_row, contents.take());
    run("COMMIT");
    sqlite3_close(connection_);
  }

  void put(const std::string& table, std::int64_t id, const std::string& body) {
    const std::int64_t checksum = row_checksum(table, id, body);
    std::string hex;
    for (const char c : body) {
      constexpr char digits[] = "0123456789abcdef";
      const auto byte = static_cast<unsigned char>(c);
      hex += digits[byte >> 4];
      hex += digits[byte & 15];
    }
    run("INSERT INTO " + table + " VALUES (" + std::to_string(id) + ", " + std::to_string(checksum) + ", x'" + hex +
        "')");
    ByteWriter bytes;
    bytes.put(checksum);
    hashes_[table].add(bytes.take());
    ++rows_[table];
  }

 private:
  void run(const std::string& sql) {
    EXPECT_EQ(sqlite3_exec(connection_, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(connection_);
  }

  std::uint32_t version_;
  sqlite3* connection_ = nullptr;
  std::map<std::string, std::int64_t> rows_;
  std::map<std::string, Sha256> hashes_;
};

void put_raw(ByteWriter& bytes, const auto& values) { bytes.put_raw(values.data(), values.size() * sizeof values[0]); }

void put_trajectory(const Map& map, OldFile& file) {
  std::int64_t row = 0;
  for (const StampedPose& pose : trajectory_of(map)) {
    ByteWriter bytes;
    bytes.put(pose.stamp);
    put(bytes, pose.world_from_body);
    file.put("way", row++, bytes.take());
  }
}

std::string old_image(const ImageFeatures& image) {
  ByteWriter bytes;
  bytes.put(image.frame);
  bytes.put(image.stamp);
  bytes.put(static_cast<std::uint32_t>(image.features.size()));
  put_raw(bytes, image.features.keypoints);
  bytes.put<std::int32_t>(image.features.length);
  put(bytes, image.features.floats);
  bytes.put(static_cast<std::uint32_t>(image.features.descriptors.size()));
  put_raw(bytes, image.features.descriptors);
  put(bytes, image.depths);
  return bytes.take();
}

/// A map of a depth camera.
void write_version_1(const Map& map, const fs::path& path) {
  OldFile file(path, 1);
  ByteWriter head;
  head.put_text(map.method);
  put(head, map.cameras[0].intrinsics);
  head.put(map.cameras[0].depth_noise.sigma_m);
  head.put(map.cameras[0].depth_noise.sigma_per_m2);
  const std::string head_row = head.take();
  file.put("head", 0, head_row);
  for (const Keyframe& keyframe : map.keyframes) {
    file.put("keyframes", keyframe.id, old_image(*map.layer<FeatureLayer>()->find(keyframe.id)));
    file.put("pictures", keyframe.id, body_of(images_of(map)->read(keyframe.id)));
    ByteWriter pose;
    pose.put<std::int32_t>(keyframe.submap);
    put(pose, keyframe.world_from_camera);
    file.put("poses", keyframe.id, pose.take());
  }
  for (std::size_t i = 0; i < map.constraints.size(); ++i) {
    const Constraint& edge = map.constraints[i];
    ByteWriter bytes;
    bytes.put(edge.from);
    bytes.put(edge.to);
    bytes.put(static_cast<std::uint8_t>(edge.kind));
    bytes.put(edge.weight);
    put(bytes, edge.rigid());
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column < 6; ++column) bytes.put(edge.information(row, column));
    file.put("edges", static_cast<std::int64_t>(i), bytes.take());
  }
  put_trajectory(map, file);
}

std::string old_landmark(const Landmark& landmark) {
  ByteWriter bytes;
  put(bytes, landmark.position);
  put(bytes, landmark.direction);
  put_raw(bytes, landmark.descriptor.words);
  bytes.put(landmark.min_distance);
  bytes.put(landmark.max_distance);
  bytes.put(static_cast<std::uint32_t>(landmark.observations.size()));
  for (const LandmarkObservation& observation : landmark.observations) {
    bytes.put(observation.keyframe);
    bytes.put(observation.feature);
  }
  return bytes.take();
}

std::string old_landmark_image(const ImageFeatures& image) {
  ByteWriter bytes;
  bytes.put(image.frame);
  bytes.put(image.stamp);
  bytes.put(static_cast<std::uint32_t>(image.features.size()));
  put_raw(bytes, image.features.keypoints);
  put_raw(bytes, image.features.levels);
  put_raw(bytes, image.features.descriptors);
  put(bytes, image.right_x);
  put(bytes, image.depths);
  return bytes.take();
}

std::string old_landmark_head(const Map& map) {
  ByteWriter head;
  head.put_text("map of landmarks");
  head.put_text(map.method);
  head.put(static_cast<std::uint8_t>(map.cameras[0].kind));
  put(head, map.cameras[0].intrinsics);
  head.put(map.cameras[0].baseline);
  head.put(static_cast<std::uint8_t>(scale_of(map).metric));
  head.put(scale_of(map).relative_sigma);
  head.put_text(scale_of(map).origin);
  put(head, map.layer<FeatureLayer>()->extraction);
  return head.take();
}

void write_version_2(const Map& map, const fs::path& path) {
  OldFile file(path, 2);
  file.put("head", 0, old_landmark_head(map));
  for (const Keyframe& keyframe : map.keyframes) {
    file.put("keyframes", keyframe.id, old_landmark_image(*map.layer<FeatureLayer>()->find(keyframe.id)));
    ByteWriter pose;
    pose.put<std::int32_t>(keyframe.submap);
    pose.put(keyframe.parent);
    put(pose, keyframe.world_from_camera);
    file.put("poses", keyframe.id, pose.take());
  }
  for (const Landmark& landmark : map.layer<LandmarkLayer>()->landmarks)
    file.put("landmarks", landmark.id, old_landmark(landmark));
  for (std::size_t i = 0; i < map.constraints.size(); ++i) {
    const Constraint& constraint = map.constraints[i];
    ByteWriter bytes;
    bytes.put(constraint.from);
    bytes.put(constraint.to);
    bytes.put<std::int32_t>(constraint.inliers);
    bytes.put(constraint.from_from_to.scale());
    put(bytes, constraint.from_from_to.rotation());
    put(bytes, constraint.from_from_to.translation());
    file.put("ties", static_cast<std::int64_t>(i), bytes.take());
  }
  put_trajectory(map, file);
}

void expect_same_graph(const Map& now, const Map& map) {
  EXPECT_EQ(now.method, map.method);
  ASSERT_EQ(now.cameras.size(), 1U);
  EXPECT_EQ(now.cameras[0].kind, map.cameras[0].kind);
  EXPECT_EQ(now.cameras[0].baseline, map.cameras[0].baseline);
  EXPECT_EQ(now.cameras[0].depth_noise, map.cameras[0].depth_noise);
  EXPECT_EQ(now.cameras[0].intrinsics.fx, map.cameras[0].intrinsics.fx);
  EXPECT_EQ(scale_of(now).metric, scale_of(map).metric);
  EXPECT_EQ(scale_of(now).relative_sigma, scale_of(map).relative_sigma);
  EXPECT_EQ(scale_of(now).origin, scale_of(map).origin);
  ASSERT_EQ(now.keyframes.size(), map.keyframes.size());
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Keyframe &a = now.keyframes[k], &b = map.keyframes[k];
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.frame, b.frame);
    EXPECT_EQ(a.stamp, b.stamp);
    EXPECT_EQ(a.parent, b.parent);
    EXPECT_LT((a.world_from_camera.inverse() * b.world_from_camera).log().norm(), 1e-14);
    const auto image = now.layer<FeatureLayer>()->find(a.id), same_image = map.layer<FeatureLayer>()->find(b.id);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->id, a.id);
    EXPECT_EQ(image->features.descriptors, same_image->features.descriptors);
    EXPECT_EQ(image->right_x, same_image->right_x);
    EXPECT_EQ(image->depths, same_image->depths);
  }
  ASSERT_EQ(now.constraints.size(), map.constraints.size());
  for (std::size_t i = 0; i < map.constraints.size(); ++i) {
    const Constraint &a = now.constraints[i], &b = map.constraints[i];
    EXPECT_EQ(a.from, b.from);
    EXPECT_EQ(a.to, b.to);
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.inliers, b.inliers);
    EXPECT_EQ(a.information, b.information);
    EXPECT_LT((a.from_from_to.matrix() - b.from_from_to.matrix()).norm(), 1e-13);
  }
  const Trajectory a = trajectory_of(now), b = trajectory_of(map);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].stamp, b[i].stamp);
    EXPECT_LT((a[i].world_from_body.matrix() - b[i].world_from_body.matrix()).norm(), 1e-12);
  }
}

/// It can be read, recovered, and saved in the current form.
std::shared_ptr<const Map> expect_sound(const fs::path& file, std::uint32_t version) {
  const MapFileReport report = check_map_file(file);
  EXPECT_EQ(report.damage, "");
  EXPECT_EQ(report.version, version);
  EXPECT_TRUE(report.finished);
  const fs::path today = scratch_path("today.rastro"), again = scratch_path("again.rastro");
  const auto map = load_map(file);
  save_map(*map, today);
  EXPECT_EQ(check_map_file(today).version, 4U);
  save_map(*load_map(today), again);
  EXPECT_TRUE(read_whole_file(again) == read_whole_file(today));
  const RecoveredMap recovered = recover_map(file);
  EXPECT_THAT(recovered.lost, testing::IsEmpty());
  save_map(*recovered.map, again);
  EXPECT_TRUE(read_whole_file(again) == read_whole_file(today));
  return map;
}

TEST(ReadOldMap, OfADepthCameraIsRead) {
  const Map map = make_test_map(3);
  const fs::path file = scratch_path("version_1.rastro");
  write_version_1(map, file);
  const auto now = expect_sound(file, 1);
  expect_same_graph(*now, map);
  EXPECT_EQ(now->layer<ImageLayer>()->keyframes, map.layer<ImageLayer>()->keyframes);
  for (const Keyframe& keyframe : map.keyframes)
    EXPECT_EQ(images_of(*now)->read(keyframe.id), images_of(map)->read(keyframe.id));
}

TEST(ReadOldMap, OfLandmarksIsRead) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::stereo, CameraKind::depth}) {
    TestRoad road;
    road.sensor = sensor;
    const Map map = make_landmark_test_map(road);
    const fs::path file = scratch_path("version_2.rastro");
    write_version_2(map, file);
    const auto now = expect_sound(file, 2);
    expect_same_graph(*now, map);
    const auto &landmarks = map.layer<LandmarkLayer>()->landmarks, &again = now->layer<LandmarkLayer>()->landmarks;
    ASSERT_EQ(again.size(), landmarks.size());
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      EXPECT_EQ(again[i].id, landmarks[i].id);
      EXPECT_EQ(again[i].position, landmarks[i].position);
      EXPECT_EQ(again[i].descriptor, landmarks[i].descriptor);
      EXPECT_EQ(again[i].observations, landmarks[i].observations);
    }
  }
}

}  // namespace
}  // namespace rastro
