// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/signatures/signature_layer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "rastro/base/error.h"
#include "rastro/map/all_layers_testing.h"
#include "rastro/map/file/growing_map_file.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/graph/edit.h"

namespace rastro {
namespace {

using ::testing::ElementsAre;

/// Rows as a file would give them.
class Rows : public RowStore {
 public:
  std::string row(std::int64_t id) const override { return bodies.at(id); }
  std::map<std::int64_t, std::string> bodies;
};

Signature read_back(const std::string& body) {
  const auto rows = std::make_shared<Rows>();
  rows->bodies[4] = body;
  return signatures_in(rows)->read(4);
}

TEST(Signature, IsReadBackAsItWas) {
  const Signature signature = all_layers::some_signature(4);
  const Signature back = read_back(body_of(signature));
  EXPECT_THAT(back.words, ElementsAre(5, -1));
  EXPECT_EQ(back.image->features.size(), 3U);
  EXPECT_THAT(back.image->depths, ElementsAre(1.0F, 0.0F, 2.5F));
  EXPECT_EQ(body_of(back), body_of(signature));
}

TEST(Signature, MoreWordsThanFeaturesAreDamage) {
  Signature signature = all_layers::some_signature(4);
  signature.words = {1, 2, 3};
  EXPECT_NO_THROW(read_back(body_of(signature)));
  signature.words = {1, 2, 3, 4};
  EXPECT_THROW(read_back(body_of(signature)), Error);
  signature.words = {-2};
  EXPECT_THROW(read_back(body_of(signature)), Error);
}

TEST(Signature, EveryShorterBodyIsDamage) {
  const std::string body = body_of(all_layers::some_signature(4));
  for (std::size_t length = 0; length < body.size(); ++length)
    EXPECT_THROW(read_back(body.substr(0, length)), Error) << length;
}

TEST(SignatureLayer, OfAGrowingFileIsReadBeforeAndAfterItIsFinished) {
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "signatures.rastro";
  GrowingMapFile growing(file);
  const Signature signature = all_layers::some_signature(0);
  growing.add_row(SignatureLayer::layer_name, 0, body_of(signature));
  const auto store = signatures_in(growing.rows(SignatureLayer::layer_name));
  EXPECT_EQ(body_of(store->read(0)), body_of(signature));
  EXPECT_THROW(store->read(1), Error);
  Map map = make_map_of_all_layers();
  map.layers = {};
  const KeyframeId id = map.keyframes.front().id;
  growing.add_row(SignatureLayer::layer_name, id, body_of(signature));
  auto layer = std::make_shared<SignatureLayer>();
  layer->keyframes = {id};
  layer->store = store;
  map.layers.put<SignatureLayer>(std::move(layer));
  growing.finish(map);
  EXPECT_EQ(body_of(load_map(file)->layer<SignatureLayer>()->store->read(id)), body_of(signature));
  EXPECT_EQ(check_map_file(file).damage, "");
}

TEST(SignatureLayer, FollowsItsKeyframesWhenTheyAreRenumbered) {
  const Map map = make_map_of_all_layers(), result = renumbered(map);
  const auto before = map.layer<SignatureLayer>(), now = result.layer<SignatureLayer>();
  ASSERT_EQ(now->keyframes.size(), before->keyframes.size());
  for (std::size_t i = 0; i < now->keyframes.size(); ++i) {
    EXPECT_EQ(now->keyframes[i], static_cast<KeyframeId>(map.index_of(before->keyframes[i]).value()));
    EXPECT_EQ(body_of(now->store->read(now->keyframes[i])), body_of(before->store->read(before->keyframes[i])));
  }
}

}  // namespace
}  // namespace rastro
