// SPDX-License-Identifier: Apache-2.0
// How many of the places that look alike a keyframe is compared with.
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "rastro/backend/rgbd/mapper.h"
#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::edge_of;
using testing::looking;
using testing::room_frame;

/// For one keyframe some look like it; all others are compared with nothing. Notes what it is told of.
class OldPlaces : public LoopSearch {
 public:
  OldPlaces(std::int64_t asked, std::vector<std::int64_t>& compared, std::vector<std::int64_t> alike = {0, 1, 2, 3, 4})
      : asked_(asked), compared_(compared), alike_(std::move(alike)) {}
  Candidates candidates(const KeyframeGraph&, std::int64_t id) override {
    return {{}, id == asked_ ? alike_ : std::vector<std::int64_t>{}, {}};
  }
  void on_matched(const KeyframeGraph&, std::int64_t id, const Candidates& candidates,
                  std::span<const Constraint>) override {
    if (id == asked_) compared_ = candidates.places;
  }
  std::vector<std::int64_t> transfer(const KeyframeGraph&, double) override { return {}; }
  void know_constraints(std::span<const Constraint> constraints) override {
    for (const Constraint& edge : constraints) compared_.insert(compared_.end(), {edge.from, edge.to});
  }

 private:
  std::int64_t asked_;
  std::vector<std::int64_t>& compared_;
  std::vector<std::int64_t> alike_;
};

MapRevision add_in_place(Mapper& mapper, std::int64_t id, int submap) {
  const SE3 view = looking({-0.8, -0.4, 1.2}, 0.15);
  std::optional<Constraint> tracked;
  if (id > 0 && submap == 0) tracked = edge_of(id - 1, id, SE3(), ConstraintKind::odometry, 0.01, 0.005);
  return mapper.add({id, room_frame(view, 10 * id), view, submap, tracked});
}

TEST(Mapper, ThreeEarlierPlacesThatFitAreEnough) {
  for (const std::int64_t last : {46, 42}) {
    std::vector<std::int64_t> compared;
    Mapper mapper({}, test_room::camera(), {}, std::make_unique<OldPlaces>(last, compared));
    for (std::int64_t id = 0; id < last; ++id) add_in_place(mapper, id, 0);
    const MapRevision revision = add_in_place(mapper, last, 0);
    const std::size_t expected = last == 46 ? 3U : 5U;  // tracking knows the motion since keyframes 2 to 4 of 42
    EXPECT_EQ(compared.size(), expected) << last;
    EXPECT_EQ(revision.new_edges.size(), 1U + expected);
  }
}

/// The camera has gone 6 m away from ten keyframes of one view, and sees the same again.
TEST(Mapper, WhatIsBesideAPlaceThatOnlyLooksAlikeIsNotComparedToo) {
  constexpr std::int64_t last = 52;
  std::vector<std::int64_t> compared;
  Mapper mapper({}, test_room::camera(), {},
                std::make_unique<OldPlaces>(last, compared, std::vector<std::int64_t>{1, 0, 3, 6, 8, 9}));
  const SE3 view = looking({-0.8, -0.4, 1.2}, 0.15);
  MapRevision revision;
  for (std::int64_t id = 0; id <= last; ++id) {
    std::optional<Constraint> tracked;
    const SE3 moved(SO3(), {id == 10 ? 6.0 : 0.0, 0.0, 0.0});
    if (id > 0) tracked = edge_of(id - 1, id, moved, ConstraintKind::odometry, 0.01, 0.005);
    const bool same = id < 10 || id == last;
    const Frame frame = same ? room_frame(view, 10 * id) : testing::unknown_frame(static_cast<std::uint64_t>(id));
    revision = mapper.add({id, frame, view, 0, tracked});
  }
  EXPECT_EQ(revision.new_edges.size(), 1U);
  EXPECT_EQ(compared, (std::vector<std::int64_t>{1, 8})) << "0, 3 and 6 are beside 1, 9 is beside 8";
}

/// Each keyframe is asked about the same place, which only looks alike: the three that follow see no more of it.
TEST(Mapper, APlaceThatOnlyLooksAlikeIsComparedAgainAfterThreeKeyframes) {
  class OnePlace : public LoopSearch {
   public:
    explicit OnePlace(std::vector<std::int64_t>& comparing) : comparing_(comparing) {}
    Candidates candidates(const KeyframeGraph&, std::int64_t id) override {
      return {{}, id >= 50 ? std::vector<std::int64_t>{1} : std::vector<std::int64_t>{}, {}};
    }
    void on_matched(const KeyframeGraph&, std::int64_t id, const Candidates& candidates,
                    std::span<const Constraint>) override {
      if (!candidates.places.empty()) comparing_.push_back(id);
    }
    std::vector<std::int64_t> transfer(const KeyframeGraph&, double) override { return {}; }

   private:
    std::vector<std::int64_t>& comparing_;
  };
  std::vector<std::int64_t> comparing;
  Mapper mapper({}, test_room::camera(), {}, std::make_unique<OnePlace>(comparing));
  const SE3 view = looking({-0.8, -0.4, 1.2}, 0.15);
  for (std::int64_t id = 0; id < 60; ++id) {
    std::optional<Constraint> tracked;
    const SE3 moved(SO3(), {id == 10 ? 6.0 : 0.0, 0.0, 0.0});
    if (id > 0) tracked = edge_of(id - 1, id, moved, ConstraintKind::odometry, 0.01, 0.005);
    const bool same = id < 10 || id >= 50;
    const Frame frame = same ? room_frame(view, 10 * id) : testing::unknown_frame(static_cast<std::uint64_t>(id));
    mapper.add({id, frame, view, 0, tracked});
  }
  EXPECT_EQ(comparing, (std::vector<std::int64_t>{50, 54, 58}));
}

TEST(Mapper, AnEdgeBetweenPlacesRevisitedIsALinkBetweenThem) {
  std::vector<std::int64_t> told;
  Mapper mapper({}, test_room::camera(), {}, std::make_unique<OldPlaces>(1000, told));
  for (std::int64_t id = 0; id < 3; ++id) add_in_place(mapper, id, 0);
  ASSERT_TRUE(told.empty()) << "of a keyframe's own it is told otherwise";
  mapper.connect(edge_of(2, 0, SE3(), ConstraintKind::proximity));
  EXPECT_EQ(told, (std::vector<std::int64_t>{2, 0}));
}

/// Each connects a submap more.
TEST(Mapper, PlacesOfOtherSubmapsAreComparedInAnyCase) {
  std::vector<std::int64_t> compared;
  Mapper mapper({}, test_room::camera(), {}, std::make_unique<OldPlaces>(46, compared));
  add_in_place(mapper, 0, 0);
  for (std::int64_t id = 1; id < 5; ++id) add_in_place(mapper, id, static_cast<int>(id));
  for (std::int64_t id = 5; id <= 46; ++id) add_in_place(mapper, id, 5);
  EXPECT_EQ(compared.size(), 5U);
}

}  // namespace
}  // namespace rastro
