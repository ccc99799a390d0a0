// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/graph/edit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/all_layers_testing.h"
#include "rastro/map/file/map_file.h"

namespace rastro {
namespace {

std::vector<KeyframeId> ids_of(const Map& map) {
  std::vector<KeyframeId> ids;
  for (const Keyframe& keyframe : map.keyframes) ids.push_back(keyframe.id);
  return ids;
}

/// All of a map except its revision.
std::string bytes_of(Map map) {
  map.revision = 0;
  const std::filesystem::path file = scratch_path("edited.rastro");
  save_map(map, file);
  return read_whole_file(file);
}

TEST(InsertKeyframe, KeepsTheOrderOfIds) {
  Map map;
  map.cameras.resize(2);
  Keyframe keyframe;
  for (const KeyframeId id : {30, 10, 20, 40, 0}) {
    const std::int64_t before = map.revision;
    keyframe.id = id;
    insert_keyframe(map, keyframe);
    EXPECT_GT(map.revision, before);
  }
  EXPECT_EQ(ids_of(map), (std::vector<KeyframeId>{0, 10, 20, 30, 40}));
  EXPECT_EQ(contradiction_in(map), "");
}

TEST(InsertKeyframe, RefusesInvalidKeyframes) {
  Map map;
  map.cameras.resize(2);
  Keyframe first;
  first.id = 10, first.camera = 1;
  insert_keyframe(map, first);
  const auto revision = map.revision;
  Keyframe twice = first, negative = first, camera = first, parent = first, own_parent = first;
  negative.id = -1;
  camera.id = 11, camera.camera = 2;
  parent.id = 11, parent.parent = 9;
  own_parent.id = own_parent.parent = 11;
  for (const Keyframe& bad : {twice, negative, camera, parent, own_parent})
    EXPECT_THROW(insert_keyframe(map, bad), Error) << bad.id;
  EXPECT_EQ(ids_of(map), std::vector<KeyframeId>{10});
  EXPECT_EQ(map.revision, revision);
}

TEST(RemoveKeyframe, TakesAllThatGoesWithIt) {
  Map map = make_map_of_all_layers();
  const KeyframeId id = map.keyframes[2].id, parent = map.keyframes[2].parent;
  const std::size_t frames = map.frames.size(), constraints = map.constraints.size();
  const RemovedKeyframe removed = remove_keyframe(map, id);
  EXPECT_EQ(removed.keyframe.id, id);
  EXPECT_FALSE(map.find(id));
  EXPECT_EQ(contradiction_in(map), "");
  EXPECT_GT(map.revision, 17);
  EXPECT_EQ(removed.children.size(), 2U);
  for (const KeyframeId child : removed.children) EXPECT_EQ(map.find(child)->parent, parent);
  EXPECT_EQ(removed.frames.size() + map.frames.size(), frames);
  EXPECT_EQ(removed.constraints.size() + map.constraints.size(), constraints);
  EXPECT_FALSE(map.layer<FeatureLayer>()->find(id));
  EXPECT_FALSE(map.layer<ScanLayer>()->find(id));
  EXPECT_FALSE(map.layer<WordLayer>()->find(id));
  for (const Landmark& landmark : map.layer<LandmarkLayer>()->landmarks)
    for (const LandmarkObservation& observation : landmark.observations) EXPECT_NE(observation.keyframe, id);
  EXPECT_THROW(remove_keyframe(map, id), Error);
}

TEST(RestoreKeyframe, RestoresTheSameMap) {
  const Map map = make_map_of_all_layers();
  const std::string bytes = bytes_of(map);
  for (const Keyframe& keyframe : map.keyframes) {
    Map edited = map;
    const RemovedKeyframe removed = remove_keyframe(edited, keyframe.id);
    EXPECT_NE(bytes_of(edited), bytes) << keyframe.id;
    const std::int64_t revision = edited.revision;
    restore_keyframe(edited, removed);
    EXPECT_GT(edited.revision, revision);
    EXPECT_TRUE(bytes_of(edited) == bytes) << keyframe.id;
  }
}

TEST(RestoreKeyframe, RestoresSeveralInReverseOrder) {
  const Map map = make_map_of_all_layers();
  Map edited = map;
  std::vector<RemovedKeyframe> removed;
  for (const Keyframe& keyframe : map.keyframes) removed.push_back(remove_keyframe(edited, keyframe.id));
  EXPECT_TRUE(edited.keyframes.empty());
  EXPECT_EQ(contradiction_in(edited), "");
  for (auto each = removed.rbegin(); each != removed.rend(); ++each) restore_keyframe(edited, *each);
  EXPECT_TRUE(bytes_of(edited) == bytes_of(map));
}

TEST(RestoreKeyframe, LeavesOutReferencesToRemovedKeyframes) {
  Map map = make_map_of_all_layers();
  const KeyframeId from = map.keyframes[1].id, to = map.keyframes.back().id;
  const RemovedKeyframe removed = remove_keyframe(map, from);
  EXPECT_EQ(removed.constraints.size(), 1U);
  remove_keyframe(map, to);
  remove_keyframe(map, removed.keyframe.parent);
  map.layers.put<WordLayer>(nullptr);
  restore_keyframe(map, removed);
  EXPECT_EQ(contradiction_in(map), "");
  EXPECT_EQ(map.find(from)->parent, no_keyframe);
  EXPECT_FALSE(map.layer<WordLayer>());
  EXPECT_TRUE(map.layer<FeatureLayer>()->find(from));
  for (const Constraint& constraint : map.constraints) EXPECT_NE(constraint.from, from);
}

/// With a layer of another program.
Map with_unknown_layer(Map map) {
  auto unknown = std::make_shared<UnknownLayer>();
  for (const Keyframe& keyframe : map.keyframes) unknown->rows.emplace_back(keyframe.id, "of a keyframe");
  map.layers.put("made_up", unknown);
  return map;
}

TEST(RemoveKeyframe, LeavesNoLayerThatItCannotUpdate) {
  const Map map = with_unknown_layer(make_map_of_all_layers());
  Map edited = map;
  const RemovedKeyframe first = remove_keyframe(edited, map.keyframes[1].id);
  EXPECT_FALSE(edited.layers.find("made_up")) << "its rows may be of the keyframe, or name it";
  const RemovedKeyframe second = remove_keyframe(edited, map.keyframes[2].id);
  Map other_order = edited;
  restore_keyframe(edited, second);
  EXPECT_FALSE(edited.layers.find("made_up"));
  restore_keyframe(edited, first);
  EXPECT_EQ(edited.layers.find("made_up"), map.layers.find("made_up"));
  restore_keyframe(other_order, first);
  EXPECT_FALSE(other_order.layers.find("made_up")) << "the second is still missing";
}

TEST(Renumbered, LeavesOutALayerThatItCannotUpdate) {
  const Map map = with_unknown_layer(make_map_of_all_layers()), result = renumbered(map);
  EXPECT_FALSE(result.layers.find("made_up"));
  EXPECT_EQ(result.layers.all().size() + 1, map.layers.all().size());
  const Map same = with_unknown_layer(result);
  EXPECT_EQ(renumbered(same).layers.find("made_up"), same.layers.find("made_up")) << "no number changed";
}

TEST(Renumbered, KeepsGeometryObservationsAndLayers) {
  const Map map = make_map_of_all_layers();
  const Map result = renumbered(map);
  EXPECT_EQ(contradiction_in(result), "");
  ASSERT_EQ(result.keyframes.size(), map.keyframes.size());
  const auto number = [&](KeyframeId id) {
    return id == no_keyframe ? no_keyframe : static_cast<KeyframeId>(map.index_of(id).value());
  };
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Keyframe &before = map.keyframes[k], &now = result.keyframes[k];
    EXPECT_EQ(now.id, static_cast<KeyframeId>(k));
    EXPECT_EQ(now.parent, number(before.parent));
    EXPECT_EQ(now.world_from_camera.matrix(), before.world_from_camera.matrix());
    const ImageFeatures* image = map.layer<FeatureLayer>()->find(before.id);
    const ImageFeatures* same_image = result.layer<FeatureLayer>()->find(now.id);
    ASSERT_EQ(same_image != nullptr, image != nullptr);
    if (image) {
      EXPECT_EQ(same_image->id, now.id);
      EXPECT_EQ(same_image->features.descriptors, image->features.descriptors);
    }
    EXPECT_EQ(result.layer<ScanLayer>()->find(now.id), map.layer<ScanLayer>()->find(before.id));
    EXPECT_EQ(result.layer<SemiDenseLayer>()->find(now.id), map.layer<SemiDenseLayer>()->find(before.id));
    EXPECT_EQ(result.layer<WordLayer>()->find(now.id), map.layer<WordLayer>()->find(before.id));
  }
  for (std::size_t i = 0; i < map.constraints.size(); ++i) {
    EXPECT_EQ(result.constraints[i].from, number(map.constraints[i].from));
    EXPECT_EQ(result.constraints[i].to, number(map.constraints[i].to));
  }
  const auto before = trajectory_of(map), now = trajectory_of(result);
  ASSERT_EQ(now.size(), before.size());
  for (std::size_t i = 0; i < now.size(); ++i)
    EXPECT_EQ(now[i].world_from_body.matrix(), before[i].world_from_body.matrix());
  const auto &landmarks = map.layer<LandmarkLayer>()->landmarks, &again = result.layer<LandmarkLayer>()->landmarks;
  ASSERT_EQ(again.size(), landmarks.size());
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    ASSERT_EQ(again[i].observations.size(), landmarks[i].observations.size());
    for (std::size_t j = 0; j < landmarks[i].observations.size(); ++j) {
      EXPECT_EQ(again[i].observations[j].keyframe, number(landmarks[i].observations[j].keyframe));
      EXPECT_EQ(again[i].observations[j].feature, landmarks[i].observations[j].feature);
    }
  }
}

TEST(Renumbered, KeepsImages) {
  const Map map = make_map_of_all_layers(), result = renumbered(map);
  const auto before = map.layer<ImageLayer>(), now = result.layer<ImageLayer>();
  ASSERT_EQ(now->keyframes.size(), before->keyframes.size());
  for (std::size_t i = 0; i < now->keyframes.size(); ++i) {
    EXPECT_EQ(now->keyframes[i], static_cast<KeyframeId>(map.index_of(before->keyframes[i]).value()));
    EXPECT_EQ(now->store->read(now->keyframes[i]), before->store->read(before->keyframes[i]));
  }
}

TEST(Renumbered, LeavesANumberedMapAlone) {
  const Map once = renumbered(make_map_of_all_layers());
  EXPECT_TRUE(bytes_of(renumbered(once)) == bytes_of(once));
  EXPECT_EQ(renumbered(once).layers.all(), once.layers.all()) << "the very layers";
  EXPECT_TRUE(renumbered(Map()).keyframes.empty());
}

}  // namespace
}  // namespace rastro
