// SPDX-License-Identifier: Apache-2.0
// Guarantees of every SLAM method. Methods are found through the generated list.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <thread>

#include "accuracy_testing.h"
#include "hostile_testing.h"
#include "place_testing.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/base/text_file.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/methods/methods.h"
#include "slam_testing.h"

namespace rastro {
namespace {

/// A method, and its sensor where it has several ("orb_mono").
class SlamContract : public testing::TestWithParam<std::string> {
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
  std::unique_ptr<Slam> make(const SourceInfo& info, const SlamContext& context = {}) const {
    return method()->make(info, context);
  }
  std::unique_ptr<Slam> make() const { return make(recording().info()); }
  /// For many runs that are about their frames: without a refinement of the whole map at the end, where it is the
  /// method's option.
  std::unique_ptr<Slam> make_unrefined() const {
    const auto unrefined = method();
    OptionTable table = unrefined->options();
    for (const Option& option : table.options())
      if (option.name == "refine_iterations") table.set(option.name, "0", "the contract");
    return unrefined->make(recording().info(), {});
  }
  const TestRecording& recording() const { return *recording_; }
  AccuracyLimit limit() const { return accuracy_limit(GetParam()); }

  SlamReason said_of(const Hostile& hostile) const {
    const auto found = hostile.said.find(method()->name());
    return found == hostile.said.end() ? SlamReason::none : found->second;
  }

  /// Processes all, checks every update, and finishes.
  static std::vector<SlamUpdate> updates_of(Slam& slam, const std::vector<Frame>& frames) {
    std::vector<SlamUpdate> updates;
    for (const Frame& frame : frames) {
      updates.push_back(slam.process(frame));
      expect_sound(updates.back(), frame);
    }
    slam.finish();
    expect_sound(slam.trajectory());
    EXPECT_NE(slam.snapshot(), nullptr);
    if (slam.snapshot()) expect_sound(*slam.snapshot());
    return updates;
  }

  /// The poses in `range` are within the method's limit, times `factor`, and as many as there should be.
  void expect_right(const Slam& slam, FrameRange range = {}, double factor = 1.0) const {
    const Trajectory trajectory = slam.trajectory();
    range.end = std::min(range.end, recording().frame_count());
    const auto poses = static_cast<double>(paired_positions(trajectory, recording(), range).ground_truth.size());
    const double worst_m = worst_error_m(trajectory, recording(), range);
    RecordProperty("worst_m", std::to_string(worst_m));
    EXPECT_LT(worst_m, factor * limit().worst_m);
    EXPECT_GE(poses, limit().least_poses * (range.end - range.first));
  }

  static void run(Slam& slam, const std::vector<Frame>& frames) { updates_of(slam, frames); }

  /// All results of a run, as text.
  std::string text_of_run(const SlamContext& context) const {
    const auto slam = make(recording().info(), context);
    std::string text;
    for (const Frame& frame : recording().frames(recording().long_count())) text += text_of(slam->process(frame));
    for (const SlamEvent& event : slam->finish()) text += event.kind + ":" + event.detail + "\n";
    return text + text_of(slam->trajectory()) + text_of(*slam->snapshot());
  }

 private:
  std::unique_ptr<TestRecording> recording_ = recording_for(*method(), sensor());
};

TEST_P(SlamContract, SaysWhatItIsAndWhatItCanBeSetTo) {
  const auto method = this->method();
  EXPECT_FALSE(method->summary().empty());
  EXPECT_FALSE(method->needs().empty());
  OptionTable table = method->options();
  EXPECT_FALSE(table.options().empty());
  for (const Option& option : table.options()) EXPECT_FALSE(option.why.empty()) << option.name;
  table.load_yaml_text(table.to_yaml(), "its own settings");
  EXPECT_THROW(table.set("nonsense", "1", "a test"), Error);
}

TEST_P(SlamContract, BeginsAnewAfterAReset) {
  const auto fresh = make(), again = make();
  const std::vector<Frame> frames = recording().frames(recording().long_count());
  run(*fresh, frames);
  for (std::size_t k = 0; k < frames.size() / 2; ++k) again->process(frames[k]);
  again->reset();
  EXPECT_TRUE(again->trajectory().empty());
  run(*again, frames);
  EXPECT_EQ(text_of(again->trajectory()), text_of(fresh->trajectory()));
  EXPECT_EQ(text_of(*again->snapshot()), text_of(*fresh->snapshot()));
}

TEST_P(SlamContract, LeavesTheMapAloneWhileMappingIsOff) {
  const auto slam = make();
  const std::vector<Frame> frames = recording().frames(recording().long_count());
  const std::size_t half = frames.size() / 2;
  for (std::size_t k = 0; k < half; ++k) slam->process(frames[k]);
  if (!slam->set_mapping(false)) GTEST_SKIP() << "the method cannot switch mapping off";
  const std::size_t keyframes = slam->snapshot()->keyframes.size(), poses = slam->trajectory().size();
  const std::string kept = text_of_kept(*slam->snapshot());
  int tracked = 0;
  for (std::size_t k = half; k < half + 5; ++k) {
    const SlamState state = slam->process(frames[k]).state;
    tracked += state == SlamState::tracking || state == SlamState::weak ? 1 : 0;
  }
  EXPECT_EQ(slam->snapshot()->keyframes.size(), keyframes);
  // A filter localizes by updating its landmarks.
  if (!slam->snapshot()->layer<LandmarkLayer>() || slam->snapshot()->layer<FeatureLayer>()) {
    EXPECT_TRUE(text_of_kept(*slam->snapshot()) == kept) << "the map changed";
  }
  EXPECT_EQ(tracked, 5);
  EXPECT_EQ(slam->trajectory().size(), poses + 5);
  EXPECT_TRUE(slam->set_mapping(true));
  for (std::size_t k = half + 5; k < frames.size(); ++k) slam->process(frames[k]);
  slam->finish();
  EXPECT_GT(slam->snapshot()->keyframes.size(), keyframes);
  expect_right(*slam, {}, 2.0);
}

TEST_P(SlamContract, ObservationsAreOfTheLastFrameAndItsMap) {
  const auto slam = make();
  SlamUpdate last;
  for (const Frame& frame : recording().frames(recording().long_count())) last = slam->process(frame);
  const std::vector<FeatureObservation> observations = slam->observations();
  if (observations.empty()) GTEST_SKIP() << "the method has no features";
  const auto landmarks = slam->snapshot()->layer<LandmarkLayer>();
  int inliers = 0, known = 0;
  for (const FeatureObservation& each : observations) {
    EXPECT_TRUE(each.pixel.allFinite());
    inliers += each.state == ObservationState::inlier ? 1 : 0;
    known += landmarks && each.landmark >= 0 && landmarks->find(each.landmark) ? 1 : 0;
  }
  EXPECT_GT(inliers, 0);
  EXPECT_LE(inliers, last.used) << "surfaces may count as well";
  if (!landmarks) return;
  EXPECT_GT(known, inliers / 3) << "the others were culled since, or are seen with depth alone";
}

TEST_P(SlamContract, RefusesASourceWithoutWhatItNeeds) {
  SourceInfo nothing;
  nothing.path = "nothing.log";
  nothing.has_image = false;
  try {
    make(nothing);
    FAIL() << "a source with nothing at all was taken";
  } catch (const Error& error) {
    const std::string line = error.what();
    EXPECT_THAT(line, testing::HasSubstr("nothing.log"));
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

TEST_P(SlamContract, FollowsARobotThroughARoom) {
  const auto slam = make();
  run(*slam, recording().frames());
  expect_right(*slam);
  EXPECT_GT(slam->snapshot()->revision, 0);
}

/// The limit is meaningful: a guess fails it.
TEST_P(SlamContract, CheapGuessesFailItsLimit) {
  for (const auto& [what, trajectory] : cheap_guesses(recording())) {
    const double worst = worst_error_m(trajectory, recording());
    EXPECT_GT(worst, limit().worst_m) << what;
  }
}

TEST_P(SlamContract, WorksOrRefusesWithoutOdometry) {
  SourceInfo info = recording().info();
  info.has_odometry = false;
  std::unique_ptr<Slam> slam;
  try {
    slam = make(info);
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("odometry"));
    return;
  }
  std::vector<Frame> frames = recording().frames();
  for (Frame& frame : frames) frame.odometry_from_body.reset();
  run(*slam, frames);
  expect_right(*slam);
}

TEST_P(SlamContract, SurvivesNoFrameAndOneFrame) {
  const auto none = make();
  run(*none, {});
  EXPECT_TRUE(none->trajectory().empty());
  const auto one = make();
  run(*one, {recording().frame(0)});
  EXPECT_LE(one->trajectory().size(), 1U);
}

TEST_P(SlamContract, CanBeAskedAtAnyTime) {
  const auto slam = make();
  EXPECT_TRUE(slam->trajectory().empty());
  ASSERT_NE(slam->snapshot(), nullptr);
  std::int64_t revision = slam->snapshot()->revision;
  for (int k = 0; k < 20; ++k) {
    slam->process(recording().frame(k));
    expect_sound(slam->trajectory());
    EXPECT_GE(slam->snapshot()->revision, revision);
    revision = slam->snapshot()->revision;
  }
}

TEST_P(SlamContract, SaysWhatIsWrongWithASpoiltFrameAndGoesOn) {
  constexpr std::size_t recovery = 3;  // frames
  for (const Hostile& hostile : spoilt_for(recording())) {
    SCOPED_TRACE(hostile.what);
    std::vector<Frame> frames = recording().frames();
    const std::size_t spoilt = frames.size() / 2;
    hostile.spoil(frames[spoilt]);
    const auto slam = make_unrefined();
    const std::vector<SlamUpdate> updates = updates_of(*slam, frames);
    const SlamReason expected = said_of(hostile);
    EXPECT_EQ(updates[spoilt].reason, expected) << name_of(updates[spoilt].reason);
    EXPECT_EQ(updates[spoilt].state == SlamState::tracking, expected == SlamReason::none)
        << name_of(updates[spoilt].state);
    EXPECT_EQ(updates[spoilt + recovery].state, SlamState::tracking);
    EXPECT_EQ(updates[spoilt + recovery].reason, SlamReason::none);
    const double factor = spoilt_factor(GetParam(), hostile.what);
    expect_right(*slam, {0, static_cast<int>(spoilt)}, factor);
    expect_right(*slam, {static_cast<int>(spoilt + recovery), static_cast<int>(frames.size())}, factor);
  }
}

/// Frames that are visibly invalid by themselves never give a pose with state tracking, except the first, which is
/// compared with no other.
TEST_P(SlamContract, TracksNothingInARunOfNothingButSpoiltFrames) {
  const std::vector<SlamReason> blind = {SlamReason::no_data,    SlamReason::few_returns,   SlamReason::no_odometry,
                                         SlamReason::poor_match, SlamReason::dark_or_blank, SlamReason::degenerate};
  for (const Hostile& hostile : spoilt_for(recording())) {
    SCOPED_TRACE(hostile.what);
    std::vector<Frame> frames = recording().frames(12);
    for (Frame& frame : frames) hostile.spoil(frame);
    const auto slam = make();
    const std::vector<SlamUpdate> updates = updates_of(*slam, frames);
    expect_sound(slam->trajectory());
    if (std::find(blind.begin(), blind.end(), said_of(hostile)) == blind.end()) continue;
    for (std::size_t k = 1; k < updates.size(); ++k) {
      EXPECT_NE(updates[k].state, SlamState::tracking) << k;
      EXPECT_NE(updates[k].state, SlamState::relocalized) << k;
      EXPECT_NE(updates[k].reason, SlamReason::none) << k;
    }
  }
}

TEST_P(SlamContract, SurvivesRepeatedAndMissingFrames) {
  std::vector<Frame> frames = recording().frames();
  frames.insert(frames.begin() + 20, frames[19]);
  frames.erase(frames.begin() + 40, frames.begin() + 43);
  const auto slam = make();
  const std::vector<SlamUpdate> updates = updates_of(*slam, frames);
  EXPECT_EQ(updates[20].reason, SlamReason::repeated_frame);
  const Trajectory trajectory = slam->trajectory();
  EXPECT_LT(worst_error_m(trajectory, recording()), limit().worst_m);
  const double missing = 3.0;
  EXPECT_GE(static_cast<double>(trajectory.size()), limit().least_poses * (recording().frame_count() - missing));
}

/// As in logs of two computers: one stamp in two comes from a clock that goes back slowly.
TEST_P(SlamContract, KeepsEveryPoseInTheRoomWhereStampsGoBack) {
  if (!recording().is_metric()) GTEST_SKIP() << "a room of no known size";
  std::vector<Frame> frames = recording().frames(3 * recording().frame_count());
  for (std::size_t k = 2; k < frames.size(); k += 2)
    frames[k].stamp = recording().stamp(0) - static_cast<TimeNs>(k) * 1000;
  const auto slam = make();
  run(*slam, frames);
  for (const StampedPose& pose : slam->trajectory())
    EXPECT_LT(pose.world_from_body.translation().norm(), recording().reach_m() + limit().worst_m) << pose.stamp;
}

TEST_P(SlamContract, SurvivesOdometryThatJumps) {
  std::vector<Frame> frames = recording().frames();
  if (!recording().info().has_odometry) GTEST_SKIP() << "made for recordings without odometry";
  for (std::size_t k = 40; k < frames.size(); ++k)
    frames[k].odometry_from_body = SE2(SO2::from_angle(2.0), {500.0, -300.0}) * *frames[k].odometry_from_body;
  const auto slam = make();
  const std::vector<SlamUpdate> updates = updates_of(*slam, frames);
  EXPECT_EQ(updates[40].reason, SlamReason::odometry_jumped);
  EXPECT_NE(updates[41].reason, SlamReason::odometry_jumped) << "it jumped once";
  EXPECT_EQ(updates[45].state, SlamState::tracking);
  expect_right(*slam);
}

TEST_P(SlamContract, GivesTheSameBytesAgainAndForAnyNumberOfThreads) {
  const std::string once = text_of_run({});
  EXPECT_GT(once.size(), 1000U);
  for (const int threads : {1, 2, 8}) {
    TaskPool pool(threads);
    // Beside tracking, mapping may run where there is a second thread; alone it has to give the same without.
    EXPECT_EQ(text_of_run({.pool = &pool, .pipelined = threads != 2}), once) << threads << " threads";
  }
}

TEST_P(SlamContract, KeepsNothingOutsideOfItself) {
  const auto alone = make(), first = make(), second = make();
  for (const Frame& frame : recording().frames()) alone->process(frame);
  for (int k = 0; k < recording().frame_count(); ++k) {
    first->process(recording().frame(k));
    if (k > 20) second->process(recording().frame(k - 20));
  }
  EXPECT_EQ(text_of(first->trajectory()), text_of(alone->trajectory()));
  EXPECT_EQ(text_of(*first->snapshot()), text_of(*alone->snapshot()));
}

TEST_P(SlamContract, GivesSnapshotsThatNeverChange) {
  const auto slam = make();
  std::vector<std::pair<std::shared_ptr<const Map>, std::string>> kept;
  for (const Frame& frame : recording().frames()) {
    slam->process(frame);
    if (frame.index % 15 != 14) continue;
    kept.emplace_back(slam->snapshot(), "");
    kept.back().second = text_of(*kept.back().first);
  }
  slam->finish();
  kept.emplace_back(slam->snapshot(), text_of(*slam->snapshot()));
  for (const auto& [snapshot, text] : kept) EXPECT_EQ(text_of(*snapshot), text);
  EXPECT_NE(kept.front().second, kept.back().second) << "nothing was ever learned";
}

TEST_P(SlamContract, GivesSnapshotsThatAnotherThreadCanRead) {
  const auto slam = make();
  for (int k = 0; k < 30; ++k) slam->process(recording().frame(k));
  const auto snapshot = slam->snapshot();
  const std::string before = text_of(*snapshot);
  std::atomic<bool> done = false;
  int changes = 0;
  std::thread reader([&] {
    do {
      changes += text_of(*snapshot) == before ? 0 : 1;
    } while (!done);
  });
  for (int k = 30; k < recording().frame_count(); ++k) slam->process(recording().frame(k));
  slam->finish();
  done = true;
  reader.join();
  EXPECT_EQ(changes, 0);
}

TEST_P(SlamContract, KeepsItsMapInABlackSecondAndIsBackSoonAfter) {
  if (!recording().info().has_image) GTEST_SKIP() << "a laser needs no light";
  const auto slam = make();
  std::vector<Frame> frames = recording().frames(2 * recording().frame_count());
  constexpr std::size_t from = 30, to = 60;
  for (std::size_t k = from; k < to; ++k) frames[k].image = gray(frames[k], 0);
  std::size_t keyframes = 0, back = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const SlamUpdate update = slam->process(frames[k]);
    expect_sound(update, frames[k]);
    if (k >= from && k < to) {
      EXPECT_EQ(update.state, SlamState::lost) << k;
      EXPECT_EQ(update.reason, SlamReason::dark_or_blank) << k;
    }
    if (k == from) keyframes = slam->snapshot()->keyframes.size();
    if (k >= to && back == 0 && (update.state == SlamState::relocalized || update.state == SlamState::tracking))
      back = k;
  }
  slam->finish();
  EXPECT_GE(back, to);
  EXPECT_LT(back, to + 30) << "more than a second";
  EXPECT_GE(slam->snapshot()->keyframes.size(), keyframes);
  Trajectory poses = slam->trajectory();
  EXPECT_GE(poses.size(), frames.size() - 60);
  const int last = static_cast<int>(frames.size()) - 1;
  ASSERT_EQ(poses.back().stamp, recording().stamp(last));
  EXPECT_LT(worst_error_m(poses, recording(), {static_cast<int>(back) + 1}), limit().worst_m);
}

TEST_P(SlamContract, LocalizesInAMapMadeBefore) {
  if (!method()->can_localize()) GTEST_SKIP() << "makes maps only";
  const auto mapper = make();
  for (const Frame& frame : recording().frames()) mapper->process(frame);
  mapper->finish();
  const std::shared_ptr<const Map> map = mapper->snapshot();
  const Trajectory mapped = mapper->trajectory();
  const std::string before = text_of(*mapper->snapshot());
  const auto slam = make(recording().info(), {.map = map});
  // In the middle of the swing, so that the first frame seen is not the map's first.
  constexpr int from = 20;
  for (int k = from; k < recording().frame_count(); ++k)
    expect_sound(slam->process(recording().frame(k)), recording().frame(k));
  slam->finish();
  const Trajectory poses = slam->trajectory();
  ASSERT_GT(poses.size(), 15U);
  for (const StampedPose& pose : poses) {
    // In the frame of the map, which is arbitrary.
    const auto before_it =
        std::find_if(mapped.begin(), mapped.end(), [&](const StampedPose& other) { return other.stamp == pose.stamp; });
    if (before_it == mapped.end()) continue;
    const double displacement =
        (mapped.back().world_from_body.translation() - mapped.front().world_from_body.translation()).norm();
    EXPECT_LT((before_it->world_from_body.inverse() * pose.world_from_body).translation().norm(),
              recording().is_metric() ? 0.1 : 0.05 * displacement)
        << pose.stamp;
  }
  if (map->layer<ImageLayer>() && map->layer<FeatureLayer>()) {
    EXPECT_EQ(slam->snapshot()->layer<FeatureLayer>()->of, map->layer<FeatureLayer>()->of);
  }
  EXPECT_EQ(text_of(*mapper->snapshot()), before);
}

TEST_P(SlamContract, GivesAMapThatAFileKeepsAsItIs) {
  const auto slam = make();
  run(*slam, recording().frames());
  const std::shared_ptr<const Map> map = slam->snapshot();
  EXPECT_EQ(contradiction_in(*map), "");
  EXPECT_EQ(map->method, method()->name());
  EXPECT_FALSE(map->keyframes.empty());
  ASSERT_FALSE(map->sessions.empty());
  EXPECT_EQ(map->sessions.front().first_stamp, recording().stamp(0));
  EXPECT_EQ(map->sessions.front().last_stamp, recording().stamp(recording().frame_count() - 1));
  EXPECT_EQ(scale_of(*map).metric, recording().is_metric());
  const auto once = scratch_path(GetParam() + ".rastro"), again = scratch_path(GetParam() + "_again.rastro");
  save_map(*map, once);
  const auto loaded = load_map(once);
  save_map(*loaded, again);
  EXPECT_TRUE(read_text_file(once.string()) == read_text_file(again.string())) << "not the same bytes";
  EXPECT_TRUE(text_of_layers(*loaded) == text_of_layers(*map)) << "layers differ";
  ASSERT_EQ(loaded->keyframes.size(), map->keyframes.size());
  for (std::size_t k = 0; k < map->keyframes.size(); ++k) {
    const SE3 difference = map->keyframes[k].world_from_camera.inverse() * loaded->keyframes[k].world_from_camera;
    EXPECT_LT(difference.log().norm(), 1e-12) << k;
    EXPECT_EQ(loaded->keyframes[k].id, map->keyframes[k].id);
    EXPECT_EQ(loaded->keyframes[k].stamp, map->keyframes[k].stamp);
  }
  std::filesystem::remove(once);
  std::filesystem::remove(again);
}

TEST_P(SlamContract, GivesAMapWhoseFramesAreItsTrajectory) {
  const auto slam = make();
  run(*slam, recording().frames());
  const Trajectory said = slam->trajectory(), kept = trajectory_of(*slam->snapshot());
  ASSERT_EQ(kept.size(), said.size());
  for (std::size_t k = 0; k < said.size(); ++k) {
    ASSERT_EQ(kept[k].stamp, said[k].stamp);
    EXPECT_LT((said[k].world_from_body.inverse() * kept[k].world_from_body).log().norm(), 1e-6) << k;
  }
}

TEST_P(SlamContract, GivesLandmarksThatItsFeaturesShow) {
  const auto slam = make();
  for (const Frame& frame : recording().frames()) slam->process(frame);
  slam->finish();
  const auto map = slam->snapshot();
  const auto known = map->layer<LandmarkLayer>();
  if (!known || !map->layer<FeatureLayer>()) GTEST_SKIP() << "makes maps of another kind";
  ASSERT_GT(known->landmarks.size(), 100U);
  for (const Landmark& landmark : known->landmarks) {
    EXPECT_FALSE(landmark.observations.empty()) << landmark.id;
    for (const LandmarkObservation& seen : landmark.observations) {
      const ImageFeatures* image = map->layer<FeatureLayer>()->find(seen.keyframe);
      ASSERT_TRUE(image) << "landmark " << landmark.id << " keyframe " << seen.keyframe;
      EXPECT_LT(seen.feature, image->features.size());
    }
  }
}

std::vector<std::string> method_names() {
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

INSTANTIATE_TEST_SUITE_P(Methods, SlamContract, testing::ValuesIn(method_names()),
                         [](const auto& parameter) { return parameter.param; });

}  // namespace
}  // namespace rastro
