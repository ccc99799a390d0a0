// SPDX-License-Identifier: Apache-2.0
// What every SLAM method promises, whatever it does inside. Methods are found through the generated list.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <thread>

#include "place_testing.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/file/map_file.h"
#include "rastro/math/alignment.h"
#include "rastro/methods/methods.h"
#include "slam_testing.h"

namespace rastro {
namespace {

constexpr double far_off_m = 0.35;  ///< In a small room, with a method that works at all.

/// Pairs of true and estimated places, seen from the first frame.
struct Ways {
  std::vector<Eigen::Vector3d> truth, estimate;
};

Ways ways_of(const Trajectory& trajectory, const Place& place) {
  Ways ways;
  for (const StampedPose& pose : trajectory) {
    const auto k = static_cast<int>((pose.stamp - place.stamp(0) + place.step() / 2) / place.step());
    ways.truth.push_back(place.world_from_body(k).translation());
    ways.estimate.push_back(pose.world_from_body.translation());
  }
  return ways;
}

/// How far the pose of frame `end` (-1: of the last one) is from where it should be, seen from the first one; infinite
/// without one of them. Where lengths are known up to a factor: how far any pose is after alignment, with six frames of
/// ten and the last one at least.
double end_error_m(const Trajectory& trajectory, const Place& place, int end = -1) {
  if (end < 0) end = place.frame_count() - 1;
  const double nowhere = std::numeric_limits<double>::infinity();
  std::optional<SE3> first, last;
  for (const StampedPose& pose : trajectory) {
    if (pose.stamp == place.stamp(0)) first = pose.world_from_body;
    if (pose.stamp == place.stamp(end)) last = pose.world_from_body;
  }
  if (!place.is_metric()) {
    const Ways ways = ways_of(trajectory, place);
    const auto aligned = align_points(ways.truth, ways.estimate, AlignmentKind::similarity);
    if (!last || !aligned || trajectory.size() * 10 < static_cast<std::size_t>(end + 1) * 6) return nowhere;
    double most = 0.0;
    for (std::size_t i = 0; i < ways.truth.size(); ++i)
      most = std::max(most, (aligned->target_from_source * ways.estimate[i] - ways.truth[i]).norm());
    return most;
  }
  if (!first || !last) return nowhere;
  const SE3 true_motion = place.world_from_body(0).inverse() * place.world_from_body(end);
  return (true_motion.inverse() * first->inverse() * *last).translation().norm();
}

/// A method, and the sensor it is to use where it takes several ("orb_mono").
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
  std::unique_ptr<Slam> make(const SourceInfo& info, const SlamMeans& means = {}) const {
    return method()->make(info, means);
  }
  std::unique_ptr<Slam> make() const { return make(place().info()); }
  const Place& place() const { return *place_; }

  /// Processes all, checks every update, and finishes.
  static void run(Slam& slam, const std::vector<Frame>& frames) {
    for (const Frame& frame : frames) expect_sound(slam.process(frame), frame);
    slam.finish();
    expect_sound(slam.trajectory());
    ASSERT_NE(slam.snapshot(), nullptr);
    expect_sound(*slam.snapshot());
  }

  /// Everything that a run gives, as text.
  std::string text_of_run(const SlamMeans& means) const {
    const auto slam = make(place().info(), means);
    std::string text;
    for (const Frame& frame : place().frames(place().long_count())) text += text_of(slam->process(frame));
    for (const SlamEvent& event : slam->finish()) text += event.kind + ":" + event.detail + "\n";
    return text + text_of(slam->trajectory()) + text_of(*slam->snapshot());
  }

 private:
  std::unique_ptr<Place> place_ = place_for(*method(), sensor());
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
  run(*slam, place().frames());
  if (place().is_metric()) {
    EXPECT_EQ(slam->trajectory().size(), static_cast<std::size_t>(place().frame_count()));
  }
  EXPECT_LT(end_error_m(slam->trajectory(), place()), far_off_m);
  EXPECT_GT(slam->snapshot()->revision, 0);
}

TEST_P(SlamContract, WorksOrRefusesWithoutOdometry) {
  SourceInfo info = place().info();
  info.has_odometry = false;
  std::unique_ptr<Slam> slam;
  try {
    slam = make(info);
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("odometry"));
    return;
  }
  std::vector<Frame> frames = place().frames();
  for (Frame& frame : frames) frame.odometry_from_body.reset();
  run(*slam, frames);
  EXPECT_LT(end_error_m(slam->trajectory(), place()), far_off_m);
}

TEST_P(SlamContract, SurvivesNoFrameAndOneFrame) {
  const auto none = make();
  run(*none, {});
  EXPECT_TRUE(none->trajectory().empty());
  const auto one = make();
  run(*one, {place().frame(0)});
  EXPECT_LE(one->trajectory().size(), 1U);
}

TEST_P(SlamContract, CanBeAskedAtAnyTime) {
  const auto slam = make();
  EXPECT_TRUE(slam->trajectory().empty());
  ASSERT_NE(slam->snapshot(), nullptr);
  std::int64_t revision = slam->snapshot()->revision;
  for (int k = 0; k < 20; ++k) {
    slam->process(place().frame(k));
    expect_sound(slam->trajectory());
    EXPECT_GE(slam->snapshot()->revision, revision);
    revision = slam->snapshot()->revision;
  }
}

/// One bad frame in place of, or between, good ones.
struct Hostile {
  const char* what;
  void (*spoil)(Frame& frame);
};

LaserScan& scan_of(Frame& frame) { return *frame.scan; }
void fill(Frame& frame, float range) { std::fill(scan_of(frame).ranges.begin(), scan_of(frame).ranges.end(), range); }

const Hostile spoilt_scans[] = {
    {"nothing at all",
     [](Frame& frame) {
       Frame bare;
       bare.index = frame.index;
       bare.stamp = frame.stamp;
       frame = bare;
     }},
    {"no odometry", [](Frame& frame) { frame.odometry_from_body.reset(); }},
    {"no scan and no sightings",
     [](Frame& frame) {
       frame.scan.reset();
       frame.landmarks.clear();
     }},
    {"a black image and nothing else",
     [](Frame& frame) {
       frame.scan.reset();
       frame.landmarks.clear();
       frame.image = GreyImage(64, 48);
     }},
    {"an empty scan", [](Frame& frame) { scan_of(frame).ranges.clear(); }},
    {"one beam", [](Frame& frame) { scan_of(frame).ranges.resize(1); }},
    {"beams that are no number", [](Frame& frame) { fill(frame, std::numeric_limits<float>::quiet_NaN()); }},
    {"endless beams", [](Frame& frame) { fill(frame, std::numeric_limits<float>::infinity()); }},
    {"negative endless beams", [](Frame& frame) { fill(frame, -std::numeric_limits<float>::infinity()); }},
    {"beams of no length", [](Frame& frame) { fill(frame, 0.0F); }},
    {"free beams", [](Frame& frame) { fill(frame, 1e9F); }},
    {"all beams in one direction", [](Frame& frame) { scan_of(frame).angle_step = 0.0; }},
    {"sightings of no length",
     [](Frame& frame) {
       for (LandmarkSighting& sighting : frame.landmarks) sighting.range = 0.0;
     }},
    {"the same landmark everywhere",
     [](Frame& frame) {
       for (LandmarkSighting& sighting : frame.landmarks) sighting.id = 3;
     }},
    {"the stamp before", [](Frame& frame) { frame.stamp -= ns_per_second / 10; }},
    {"a stamp far back", [](Frame& frame) { frame.stamp -= 100 * ns_per_second; }},
    {"no stamp", [](Frame& frame) { frame.stamp = 0; }},
};

void fill_depth(Frame& frame, float metres) {
  for (int y = 0; y < frame.depth.height(); ++y) std::fill_n(frame.depth.row(y), frame.depth.width(), metres);
}

GreyImage grey(const Frame& frame, std::uint8_t value) {
  GreyImage image(frame.image.width(), frame.image.height());
  for (int y = 0; y < image.height(); ++y) std::fill_n(image.row(y), image.width(), value);
  return image;
}

constexpr std::size_t spoilt_images = 6;  ///< So many of them need no depth.
const Hostile spoilt_depths[] = {
    {"nothing at all",
     [](Frame& frame) {
       Frame bare;
       bare.index = frame.index;
       bare.stamp = frame.stamp;
       frame = bare;
     }},
    {"black", [](Frame& frame) { frame.image = grey(frame, 0); }},
    {"white without colour and depth",
     [](Frame& frame) {
       frame.image = grey(frame, 255);
       frame.colour = {};
       frame.depth = {};
     }},
    {"everything masked", [](Frame& frame) { frame.mask = grey(frame, 0); }},
    {"the stamp before", [](Frame& frame) { frame.stamp -= ns_per_second / 30; }},
    {"no stamp", [](Frame& frame) { frame.stamp = 0; }},
    {"no depth image", [](Frame& frame) { frame.depth = {}; }},
    {"depth without a measurement", [](Frame& frame) { fill_depth(frame, 0.0F); }},
    {"depth that is no number", [](Frame& frame) { fill_depth(frame, std::numeric_limits<float>::quiet_NaN()); }},
    {"endless depth", [](Frame& frame) { fill_depth(frame, std::numeric_limits<float>::infinity()); }},
    {"depth behind the camera", [](Frame& frame) { fill_depth(frame, -1.0F); }},
    {"flat depth", [](Frame& frame) { fill_depth(frame, 1.0F); }},
};

std::span<const Hostile> spoilt_for(const Place& place) {
  if (!place.info().cameras.empty() && !place.info().has_depth)
    return std::span<const Hostile>(spoilt_depths).first(spoilt_images);
  return place.info().has_depth ? std::span<const Hostile>(spoilt_depths) : std::span<const Hostile>(spoilt_scans);
}

TEST_P(SlamContract, SurvivesAnySpoiltFrameAndGoesOn) {
  for (const Hostile& hostile : spoilt_for(place())) {
    SCOPED_TRACE(hostile.what);
    std::vector<Frame> frames = place().frames();
    hostile.spoil(frames[frames.size() / 2]);
    const auto slam = make();
    run(*slam, frames);
    EXPECT_LT(end_error_m(slam->trajectory(), place()), far_off_m);
  }
}

TEST_P(SlamContract, SurvivesARunOfNothingButSpoiltFrames) {
  for (const Hostile& hostile : spoilt_for(place())) {
    SCOPED_TRACE(hostile.what);
    std::vector<Frame> frames = place().frames();
    frames.resize(12);
    for (Frame& frame : frames) hostile.spoil(frame);
    run(*make(), frames);
  }
}

TEST_P(SlamContract, SurvivesRepeatedAndMissingFrames) {
  std::vector<Frame> frames = place().frames();
  frames.insert(frames.begin() + 20, frames[19]);
  frames.erase(frames.begin() + 40, frames.begin() + 43);
  const auto slam = make();
  run(*slam, frames);
  EXPECT_LT(end_error_m(slam->trajectory(), place()), far_off_m);
}

/// As in logs of two computers: one stamp in two comes from a clock that goes back slowly.
TEST_P(SlamContract, KeepsEveryPoseInTheRoomWhereStampsGoBack) {
  if (!place().is_metric()) GTEST_SKIP() << "a room of no known size";
  std::vector<Frame> frames = place().frames(3 * place().frame_count());
  for (std::size_t k = 2; k < frames.size(); k += 2) frames[k].stamp = place().stamp(0) - static_cast<TimeNs>(k) * 1000;
  const auto slam = make();
  run(*slam, frames);
  for (const StampedPose& pose : slam->trajectory())
    EXPECT_LT(pose.world_from_body.translation().norm(), place().reach_m() + far_off_m) << pose.stamp;
}

TEST_P(SlamContract, SurvivesOdometryThatJumps) {
  std::vector<Frame> frames = place().frames();
  if (!place().info().has_odometry) GTEST_SKIP() << "made for recordings without odometry";
  for (std::size_t k = 40; k < frames.size(); ++k)
    frames[k].odometry_from_body = SE2(SO2::from_angle(2.0), {500.0, -300.0}) * *frames[k].odometry_from_body;
  run(*make(), frames);
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
  for (const Frame& frame : place().frames()) alone->process(frame);
  for (int k = 0; k < place().frame_count(); ++k) {
    first->process(place().frame(k));
    if (k > 20) second->process(place().frame(k - 20));
  }
  EXPECT_EQ(text_of(first->trajectory()), text_of(alone->trajectory()));
  EXPECT_EQ(text_of(*first->snapshot()), text_of(*alone->snapshot()));
}

TEST_P(SlamContract, GivesSnapshotsThatNeverChange) {
  const auto slam = make();
  std::vector<std::pair<std::shared_ptr<const Snapshot>, std::string>> kept;
  for (const Frame& frame : place().frames()) {
    slam->process(frame);
    if (frame.index % 15 != 14) continue;
    kept.emplace_back(slam->snapshot(), "");
    kept.back().second = text_of(*kept.back().first);
  }
  slam->finish();
  kept.emplace_back(slam->snapshot(), text_of(*slam->snapshot()));
  for (const auto& [snapshot, text] : kept) EXPECT_EQ(text_of(*snapshot), text);
  EXPECT_NE(kept.front().second, kept.back().second) << "nothing was ever learnt";
}

TEST_P(SlamContract, GivesSnapshotsThatAnotherThreadCanRead) {
  const auto slam = make();
  for (int k = 0; k < 30; ++k) slam->process(place().frame(k));
  const auto snapshot = slam->snapshot();
  const std::string before = text_of(*snapshot);
  std::atomic<bool> done = false;
  int changes = 0;
  std::thread reader([&] {
    do {
      changes += text_of(*snapshot) == before ? 0 : 1;
    } while (!done);
  });
  for (int k = 30; k < place().frame_count(); ++k) slam->process(place().frame(k));
  slam->finish();
  done = true;
  reader.join();
  EXPECT_EQ(changes, 0);
}

TEST_P(SlamContract, KeepsItsMapInABlackSecondAndIsBackSoonAfter) {
  if (!place().info().has_image) GTEST_SKIP() << "a laser needs no light";
  const auto slam = make();
  std::vector<Frame> frames = place().frames(2 * place().frame_count());
  constexpr std::size_t from = 30, to = 60;
  for (std::size_t k = from; k < to; ++k) frames[k].image = grey(frames[k], 0);
  std::size_t keyframes = 0, back = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const SlamUpdate update = slam->process(frames[k]);
    expect_sound(update, frames[k]);
    if (k >= from && k < to) {
      EXPECT_EQ(update.state, SlamState::lost) << k;
      EXPECT_EQ(update.reason, SlamReason::dark_or_blank) << k;
    }
    if (k == from) keyframes = slam->snapshot()->keyframes.size();
    if (k >= to && back == 0 && (update.state == SlamState::relocalised || update.state == SlamState::tracking))
      back = k;
  }
  slam->finish();
  EXPECT_GE(back, to);
  EXPECT_LT(back, to + 30) << "more than a second";
  EXPECT_GE(slam->snapshot()->keyframes.size(), keyframes);
  Trajectory poses = slam->trajectory();
  EXPECT_GE(poses.size(), frames.size() - 60);
  const int last = static_cast<int>(frames.size()) - 1;
  ASSERT_EQ(poses.back().stamp, place().stamp(last));
  EXPECT_LT(end_error_m(poses, place(), last), far_off_m);
}

TEST_P(SlamContract, FindsItsWayInAMapMadeBefore) {
  if (!method()->can_localize()) GTEST_SKIP() << "makes maps only";
  const auto mapper = make();
  for (const Frame& frame : place().frames()) mapper->process(frame);
  mapper->finish();
  const std::shared_ptr<const Snapshot> map = mapper->snapshot();
  const Trajectory mapped = mapper->trajectory();
  const std::string before = text_of(*mapper->snapshot());
  const auto slam = make(place().info(), {.map = map->rgbd, .landmark_map = map->landmark_map});
  // In the middle of the swing, so that the first frame seen is not the map's first.
  constexpr int from = 20;
  for (int k = from; k < place().frame_count(); ++k) expect_sound(slam->process(place().frame(k)), place().frame(k));
  slam->finish();
  const Trajectory poses = slam->trajectory();
  ASSERT_GT(poses.size(), 15U);
  for (const StampedPose& pose : poses) {
    // As the mapper had it: where a map lies in the world is its own affair.
    const auto before_it =
        std::find_if(mapped.begin(), mapped.end(), [&](const StampedPose& other) { return other.stamp == pose.stamp; });
    if (before_it == mapped.end()) continue;
    const double way =
        (mapped.back().world_from_body.translation() - mapped.front().world_from_body.translation()).norm();
    EXPECT_LT((before_it->world_from_body.inverse() * pose.world_from_body).translation().norm(),
              place().is_metric() ? 0.1 : 0.05 * way)
        << pose.stamp;
  }
  if (map->rgbd) {
    EXPECT_EQ(slam->snapshot()->rgbd->keyframes, map->rgbd->keyframes);
  }
  EXPECT_EQ(text_of(*mapper->snapshot()), before);
}

TEST_P(SlamContract, GivesAMapOfLandmarksThatAFileKeepsAsItIs) {
  const auto slam = make();
  for (const Frame& frame : place().frames()) slam->process(frame);
  slam->finish();
  const auto map = slam->snapshot()->landmark_map;
  if (!map) GTEST_SKIP() << "makes maps of another kind";
  ASSERT_GT(map->landmarks.size(), 100U);
  const auto file = scratch_path("landmarks.rastro");
  save_map(*map, file);
  EXPECT_EQ(text_of(*load_landmark_map(file)), text_of(*map));
  std::filesystem::remove(file);
}

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const auto& method : slam_methods()) {
    names.push_back(method->name());
    const OptionTable table = method->options();
    for (const Option& option : table.options())
      if (option.name == "sensor") names.insert(names.end(), {method->name() + "_mono", method->name() + "_stereo"});
  }
  return names;
}

INSTANTIATE_TEST_SUITE_P(Methods, SlamContract, testing::ValuesIn(method_names()),
                         [](const auto& parameter) { return parameter.param; });

}  // namespace
}  // namespace rastro
