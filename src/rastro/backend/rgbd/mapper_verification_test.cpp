// SPDX-License-Identifier: Apache-2.0
// Which matches become constraints at once, and which have to wait for a second one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "rastro/backend/rgbd/mapper.h"
#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::edge_of;
using ::testing::HasSubstr;
using testing::looking;
using testing::room_frame;
using testing::unknown_frame;

/// For one keyframe the first looks like it; all others are compared with nothing.
class FirstPlace : public LoopSearch {
 public:
  explicit FirstPlace(std::int64_t asked) : asked_(asked) {}
  Candidates candidates(const KeyframeGraph&, std::int64_t id) override {
    return {{}, id == asked_ ? std::vector<std::int64_t>{0} : std::vector<std::int64_t>{}, {}};
  }
  std::vector<std::int64_t> transfer(const KeyframeGraph&, double) override { return {}; }

 private:
  std::int64_t asked_;
};

RgbdSlamOptions judging_appearance() {
  RgbdSlamOptions options;
  options.min_alike = 0.5;
  options.loop_steps = 3;
  return options;
}

/// What becomes of the match of keyframe `last` with the first, whose view it shows again. The first edge says that the
/// camera has moved by `off_m`, the others that it stands; keyframes between show something else.
std::string said_of_return(std::int64_t last, ConstraintKind kind, double off_m) {
  Mapper mapper(judging_appearance(), test_room::camera(), {}, std::make_unique<FirstPlace>(last));
  const SE3 view = looking({-0.8, -0.4, 1.2}, 0.15);
  MapRevision revision;
  for (std::int64_t id = 0; id <= last; ++id) {
    std::optional<Constraint> path;
    const SE3 moved(SO3(), {id == 1 ? off_m : 0.0, 0.0, 0.0});
    if (id > 0) path = edge_of(id - 1, id, moved, kind, 0.3, 0.1);
    const bool between = id > 0 && id < last;
    const Frame frame = between ? unknown_frame(static_cast<std::uint64_t>(id)) : room_frame(view, 10 * id);
    revision = mapper.add({id, frame, view, 0, path});
  }
  if (revision.new_edges.size() == 2) return name_of(revision.new_edges.back().kind);
  return revision.events.empty() ? "nothing" : revision.events.front().detail;
}

TEST(MapperVerification, ALoopThatTheMapDoesNotPredictHasToBeConfirmed) {
  EXPECT_EQ(said_of_return(3, ConstraintKind::odometry, 0.15), "loop");
  EXPECT_THAT(said_of_return(3, ConstraintKind::odometry, 0.45), HasSubstr("not_confirmed"));
}

/// Over a few edges that are not of tracking, a match may be off by one of the things that repeat there.
TEST(MapperVerification, SoHasANearMatchWhereTrackingDoesNotConnectTheTwo) {
  EXPECT_EQ(said_of_return(1, ConstraintKind::loop, 0.15), "proximity");
  EXPECT_THAT(said_of_return(1, ConstraintKind::loop, 0.45), HasSubstr("not_confirmed"));
  EXPECT_EQ(said_of_return(1, ConstraintKind::odometry, 0.45), "proximity") << "the covariance of tracking decides";
}

}  // namespace
}  // namespace rastro
