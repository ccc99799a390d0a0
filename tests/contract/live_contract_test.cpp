// SPDX-License-Identifier: Apache-2.0
// Guarantees of every SLAM method in live use: initial pose, observations, memory budget of the map.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <limits>

#include "place_testing.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/file/growing_map_file.h"
#include "rastro/methods/methods.h"
#include "slam_testing.h"

namespace rastro {
namespace {

/// A method, and its sensor where it has several ("orb_mono").
class LiveContract : public testing::TestWithParam<std::string> {
 protected:
  std::string sensor() const {
    const std::size_t mark = GetParam().find('_');
    return mark == std::string::npos ? "" : GetParam().substr(mark + 1);
  }
  std::unique_ptr<SlamMethod> method() const {
    auto method = slam_method(GetParam().substr(0, GetParam().find('_')));
    if (!sensor().empty()) method->options().set("sensor", sensor(), "the contract");
    return method;
  }
  std::unique_ptr<Slam> make(const SlamContext& context = {}) const {
    return method()->make(recording_->info(), context);
  }
  const TestRecording& recording() const { return *recording_; }

  /// Far from the identity, as the method can represent it.
  SE3 initial_pose() const {
    const SE3 planar(SO3::exp({0.0, 0.0, 2.1}), {3.0, -2.0, 0.0});
    return method()->is_planar() ? planar : SE3(SO3::exp({0.4, -0.9, 2.1}), {3.0, -2.0, 7.0});
  }

  /// The results of a run, its map on disk.
  struct Run {
    std::string text;  ///< Everything that it gave.
    Trajectory trajectory;
    MapMemory memory;
    int memory_events = 0;
  };
  Run run_of(SlamContext context) const {
    const auto file = scratch_path(GetParam() + "_budget.rastro");
    Run run;
    {
      GrowingMapFile archive(file);
      context.archive = &archive;
      const auto slam = make(context);
      const auto tell = [&](const std::vector<SlamEvent>& events) {
        for (const SlamEvent& event : events) {
          run.text += event.kind + ":" + event.detail + "\n";
          run.memory_events += event.kind == "memory" ? 1 : 0;
        }
      };
      for (const Frame& frame : recording().frames(recording().long_count())) tell(slam->process(frame).events);
      tell(slam->finish());
      run.trajectory = slam->trajectory();
      run.memory = slam->map_memory();
      run.text += text_of(run.trajectory) + text_of_kept(*slam->snapshot());
    }
    std::filesystem::remove(file);
    return run;
  }

 private:
  std::unique_ptr<TestRecording> recording_ = recording_for(*method(), sensor());
};

double difference(const SE3& a, const SE3& b) { return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff(); }

TEST_P(LiveContract, AnInitialPoseMovesTheWorldAndNothingElse) {
  const SE3 initial = initial_pose();
  const auto plain = make(), moved = make({.initial_pose = initial});
  constexpr double most = 1e-9;
  for (const Frame& frame : recording().frames()) {
    const SlamUpdate a = plain->process(frame), b = moved->process(frame);
    ASSERT_EQ(a.state, b.state) << frame.index;
    ASSERT_LT(difference(initial * a.world_from_body, b.world_from_body), most) << frame.index;
    ASSERT_EQ(a.covariance.has_value(), b.covariance.has_value());
    if (!a.covariance) continue;
    const Eigen::Matrix3d rotation = initial.rotation().matrix();
    const Eigen::Matrix3d expected = rotation * a.covariance->topLeftCorner<3, 3>() * rotation.transpose();
    ASSERT_LT((expected - b.covariance->topLeftCorner<3, 3>()).norm(), most + 1e-6 * expected.norm()) << frame.index;
  }
  plain->finish();
  moved->finish();
  const Trajectory without = plain->trajectory(), with = moved->trajectory();
  ASSERT_EQ(with.size(), without.size());
  for (std::size_t k = 0; k < with.size(); ++k)
    EXPECT_LT(difference(initial * without[k].world_from_body, with[k].world_from_body), most) << k;
  const auto map = moved->snapshot(), former = plain->snapshot();
  ASSERT_EQ(map->keyframes.size(), former->keyframes.size());
  for (std::size_t k = 0; k < map->keyframes.size(); ++k)
    EXPECT_LT(difference(initial * former->keyframes[k].world_from_camera, map->keyframes[k].world_from_camera), most)
        << k;
  expect_sound(*map);
}

TEST_P(LiveContract, RefusesAnInitialPoseThatItCannotRepresent) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(make({.initial_pose = SE3(SO3(), {0.0, nan, 0.0})}), Error);
  const std::array<SE3, 2> spatial = {SE3(SO3(), {0.0, 0.0, 1.0}), SE3(SO3::exp({0.2, 0.0, 0.0}), {1.0, 2.0, 0.0})};
  for (const SE3& pose : spatial) {
    if (!method()->is_planar()) {
      EXPECT_NE(make({.initial_pose = pose}), nullptr);
      continue;
    }
    try {
      make({.initial_pose = pose});
      ADD_FAILURE() << "a method of the plane took it";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("initial pose"), testing::HasSubstr("x, y and yaw")));
    }
  }
}

TEST_P(LiveContract, LocalizesFromAnInitialPoseAndFromAWrongOne) {
  if (!method()->can_localize()) GTEST_SKIP() << "makes maps only";
  const auto mapper = make();
  for (const Frame& frame : recording().frames()) mapper->process(frame);
  mapper->finish();
  const Trajectory mapped = mapper->trajectory();
  constexpr int from = 20, last = 32;
  const auto pose_of = [&](TimeNs stamp) { return pose_at(mapped, stamp, recording().step() / 2).value_or(SE3()); };
  const SE3 right = pose_of(recording().stamp(from)), wrong = right * SE3(SO3::exp({0.0, 2.5, 0.0}), {5.0, 0.0, -4.0});
  for (const SE3& initial : {right, wrong}) {
    const auto slam = make({.map = mapper->snapshot(), .initial_pose = initial});
    for (int k = from; k < last; ++k) slam->process(recording().frame(k));
    slam->finish();
    const Trajectory poses = slam->trajectory();
    ASSERT_GE(poses.size(), static_cast<std::size_t>(last - from - 4));
    for (const StampedPose& pose : poses)
      EXPECT_LT((pose_of(pose.stamp).inverse() * pose.world_from_body).translation().norm(), 0.1) << pose.stamp;
    // In a metric map the first frame is localized at once.
    if (difference(initial, right) == 0.0) {
      EXPECT_EQ(poses.front().stamp, recording().stamp(from));
    }
  }
}

/// Part of an image that moved, or a landmark that did.
Frame disturbed(Frame frame) {
  GrayImage image = frame.image;
  constexpr int shift = 3;
  for (int y = image.height() / 4; y < image.height() * 3 / 4; ++y)
    for (int x = image.width() / 3; x < image.width() * 2 / 3; ++x) image.at(x, y) = frame.image.at(x + shift, y);
  frame.image = image;
  for (std::size_t k = 0; k < frame.landmarks.size(); k += 3) frame.landmarks[k].range *= 1.4;
  return frame;
}

TEST_P(LiveContract, ObservationsHaveTheirStatesAndChangeNothing) {
  const auto asked = make(), unasked = make();
  const int count = recording().frame_count();
  std::array<int, 5> seen{};
  int outliers_before = 0, outliers_disturbed = 0;
  std::string text_asked, text_unasked;
  for (int k = 0; k < count; ++k) {
    const bool moved = k >= count - 6;
    const Frame frame = moved ? disturbed(recording().frame(k)) : recording().frame(k);
    const SlamUpdate update = asked->process(frame);
    text_asked += text_of(update);
    text_unasked += text_of(unasked->process(frame));
    const auto observations = asked->observations();
    const auto landmarks = asked->snapshot()->layer<LandmarkLayer>();
    int inliers = 0, made = 0;
    for (const FeatureObservation& each : observations) {
      ++seen[static_cast<std::size_t>(each.state)];
      inliers += each.state == ObservationState::inlier ? 1 : 0;
      made += each.state == ObservationState::new_landmark ? 1 : 0;
      const int outlier = each.state == ObservationState::outlier ? 1 : 0;
      (moved ? outliers_disturbed : outliers_before) += outlier;
      if (each.in_body) {
        EXPECT_TRUE(each.in_body->allFinite());
        continue;
      }
      EXPECT_TRUE(each.pixel.x() >= 0.0F && each.pixel.x() < static_cast<float>(frame.image.width())) << k;
      EXPECT_TRUE(each.pixel.y() >= 0.0F && each.pixel.y() < static_cast<float>(frame.image.height())) << k;
    }
    EXPECT_LE(inliers, update.used) << k;
    if (!landmarks || landmarks->estimates.empty()) continue;
    EXPECT_LE(update.used, inliers + made) << k;
    for (const FeatureObservation& each : observations) {
      if (each.state == ObservationState::inlier) {
        EXPECT_TRUE(landmarks->find(each.landmark)) << k << ": " << each.landmark;
      }
    }
  }
  EXPECT_TRUE(text_asked == text_unasked) << "asking changed the run";
  if (std::all_of(seen.begin(), seen.end(), [](int n) { return n == 0; })) GTEST_SKIP() << "the method has no features";
  const auto of = [&](ObservationState state) { return seen[static_cast<std::size_t>(state)]; };
  EXPECT_GT(of(ObservationState::inlier), 0);
  EXPECT_GT(of(ObservationState::new_landmark), 0);
  EXPECT_GT(outliers_disturbed, 0);
  EXPECT_GT(2 * outliers_disturbed * (count - 6), 3 * outliers_before * 6) << outliers_before << " before";
}

TEST_P(LiveContract, KeepsTheMapWithinItsBudget) {
  const Run unlimited = run_of({});
  ASSERT_GT(unlimited.memory.bytes, 0U);
  EXPECT_EQ(unlimited.memory.budget_bytes, 0U);
  EXPECT_EQ(unlimited.memory_events, 0);
  const std::size_t budget = unlimited.memory.bytes / 10 * 8;
  const Run limited = run_of({.map_memory_bytes = budget});
  EXPECT_EQ(limited.memory.budget_bytes, budget);
  EXPECT_LT(limited.memory.bytes, budget) << "of " << unlimited.memory.bytes;
  EXPECT_EQ(limited.trajectory.size(), unlimited.trajectory.size());
  EXPECT_GT(limited.memory_events, 0);
  EXPECT_FALSE(limited.memory.measures.empty());
  EXPECT_TRUE(run_of({.map_memory_bytes = budget}).text == limited.text) << "not the same bytes on a rerun";
}

TEST_P(LiveContract, DropsNoFrameWhereNobodyWaits) {
  const auto slam = make();
  for (int k = 0; k < 20; ++k) slam->process(recording().frame(k));
  slam->finish();
  EXPECT_EQ(slam->dropped_frames(), 0);
}

/// Without a second thread mapping cannot fall behind, and everything is there at the next frame.
TEST_P(LiveContract, ALiveRunTracksAsWell) {
  const auto slam = make({.live = true});
  for (const Frame& frame : recording().frames()) slam->process(frame);
  slam->finish();
  EXPECT_EQ(slam->dropped_frames(), 0);
  EXPECT_GE(slam->trajectory().size(), static_cast<std::size_t>(recording().frame_count()) * 8 / 10);
}

std::vector<std::string> live_names() {
  std::vector<std::string> names;
  for (const auto& method : slam_methods()) {
    names.push_back(method->name());
    const OptionTable table = method->options();
    for (const Option& option : table.options())
      for (const std::string& choice : option.choices)
        if (option.name == "sensor" && (choice == "mono" || choice == "stereo"))
          names.push_back(method->name() + "_" + choice);
  }
  return names;
}

INSTANTIATE_TEST_SUITE_P(Methods, LiveContract, testing::ValuesIn(live_names()),
                         [](const auto& parameter) { return parameter.param; });

}  // namespace
}  // namespace rastro
