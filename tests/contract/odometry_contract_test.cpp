// SPDX-License-Identifier: Apache-2.0
// Guarantees of every odometry method. Methods are found through the generated list.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "drive_world.h"
#include "pose_testing.h"
#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/methods/methods.h"

namespace rastro {
namespace {

// Limits that a working method meets easily and a guess does not: see AGuessWouldNotPass.
constexpr DriveError good{.rotation_deg = 2.0, .position = 0.06};
// After a frame without information.
constexpr DriveError after_a_fault{.rotation_deg = 4.0, .position = 0.08};

std::string text_of(const OdometryUpdate& update) {
  return fmt::format("{} {} {} {} {} {} {} {} {} ", update.index, update.stamp, name_of(update.state),
                     name_of(update.reason), update.detail, update.used, update.matches, update.inliers,
                     update.confidence) +
         text_of(update.world_from_camera);
}

void expect_sound(const OdometryUpdate& update, const Frame& frame) {
  SCOPED_TRACE(fmt::format("frame {} ({}, {})", frame.index, name_of(update.state), name_of(update.reason)));
  EXPECT_EQ(update.index, frame.index);
  EXPECT_EQ(update.stamp, frame.stamp);
  expect_sound(update.world_from_camera);
  EXPECT_GE(update.inliers, 0);
  EXPECT_GE(update.matches, update.inliers);
  EXPECT_GE(update.confidence, 0.0);
  EXPECT_LE(update.confidence, 1.0);
  EXPECT_GE(update.milliseconds, 0.0);
}

void expect_within(const DriveError& error, const DriveError& limit) {
  EXPECT_LT(error.rotation_deg, limit.rotation_deg);
  EXPECT_LT(error.position, limit.position);
}

/// SURF may be left out of a build, and places keypoints too coarsely for steps as short as the drive's.
std::vector<std::string> settings_for_the_drive(const std::string& method) {
  if (method != "classic") return {};
  return {"matcher=sift", "max_keypoints=300", "min_parallax_deg=0.3"};
}

class OdometryContract : public testing::TestWithParam<std::string> {
 protected:
  static std::unique_ptr<OdometryMethod> method() {
    auto method = odometry_method(GetParam());
    OptionTable table = method->options();
    for (const std::string& setting : settings_for_the_drive(GetParam())) table.set_assignment(setting, "a test");
    return method;
  }
  static std::unique_ptr<Odometry> make(const SourceInfo& info = DriveWorld::info(), TaskPool* pool = nullptr) {
    return method()->make(info, {.pool = pool});
  }
  static DriveError error_of(const Odometry& odometry, const std::set<int>& left_out = {}) {
    return drive_error(odometry.trajectory(), method()->is_metric(), left_out);
  }

  /// Processes all, checks every update, and that every frame has a pose at the end.
  static void run(Odometry& odometry, const std::vector<Frame>& frames) {
    for (const Frame& frame : frames) expect_sound(odometry.process(frame), frame);
    const Trajectory poses = odometry.trajectory();
    ASSERT_EQ(poses.size(), frames.size());
    for (std::size_t k = 0; k < poses.size(); ++k) {
      EXPECT_EQ(poses[k].stamp, frames[k].stamp);
      expect_sound(poses[k].world_from_body);
    }
  }

  /// A source that lacks something is refused in one line that names it, or does.
  static void expect_refused_or_working(const SourceInfo& info, const std::vector<Frame>& frames) {
    std::unique_ptr<Odometry> odometry;
    try {
      odometry = make(info);
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(info.path));
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return;
    }
    run(*odometry, frames);
    expect_within(error_of(*odometry), good);
  }

  /// All results of a run, as text.
  static std::string text_of_run(TaskPool* pool) {
    const auto odometry = make(DriveWorld::info(), pool);
    std::string text;
    for (const Frame& frame : DriveWorld::frames()) text += text_of(odometry->process(frame));
    return text + text_of(odometry->trajectory());
  }
};

TEST_P(OdometryContract, SaysWhatItIsAndWhatItCanBeSetTo) {
  const auto method = this->method();
  EXPECT_EQ(method->name(), GetParam());
  EXPECT_THAT(method->name(), testing::MatchesRegex("[a-z_]+"));
  EXPECT_FALSE(method->summary().empty());
  EXPECT_FALSE(method->needs().empty());
  OptionTable table = method->options();
  EXPECT_FALSE(table.options().empty());
  for (const Option& option : table.options()) EXPECT_FALSE(option.why.empty()) << option.name;
  table.load_yaml_text(table.to_yaml(), "its own settings");
  EXPECT_THROW(table.set("nonsense", "1", "a test"), Error);
}

TEST_P(OdometryContract, HeedsItsSettings) {
  const auto method = this->method();
  OptionTable table = method->options();
  const std::string& name = table.options().front().name;
  const std::string before = table.value_of(0);
  const std::string allowed = table.allowed_of(0);
  SCOPED_TRACE(name + " " + allowed);
  table.set(name, allowed.substr(allowed.find_last_of(" ") + 1), "a test");
  EXPECT_NE(table.value_of(0), before) << "choose another setting here";
  EXPECT_EQ(method->options().value_of(0), table.value_of(0)) << "the table does not point into the method";
  EXPECT_EQ(this->method()->options().value_of(0), before) << "one method's settings reach another";
}

TEST_P(OdometryContract, EveryPresetChangesSettingsAndRuns) {
  for (const std::string& preset : method()->presets()) {
    const auto method = this->method();
    const OptionTable before = method->options();
    const std::string unset = before.to_yaml();
    method->set_preset(preset);
    EXPECT_NE(method->options().to_yaml(), unset) << preset;
    run(*method->make(DriveWorld::info(), {}), DriveWorld::frames(5));
  }
}

TEST_P(OdometryContract, RefusesASourceWithoutImagesOrCalibration) {
  SourceInfo nothing;
  nothing.path = "nothing.log";
  nothing.has_image = false;
  SourceInfo uncalibrated = DriveWorld::info();
  uncalibrated.path = "uncalibrated";
  uncalibrated.cameras.front().camera.reset();
  SourceInfo no_camera = uncalibrated;
  no_camera.cameras.clear();
  for (const SourceInfo& info : {nothing, uncalibrated, no_camera}) {
    try {
      make(info);
      FAIL() << info.path << " was taken";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(info.path));
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

TEST_P(OdometryContract, WorksOrRefusesWithoutDepth) {
  SourceInfo info = DriveWorld::info();
  info.path = "no depth";
  info.has_depth = false;
  std::vector<Frame> frames = DriveWorld::frames();
  for (Frame& frame : frames) frame.depth = {};
  expect_refused_or_working(info, frames);
}

TEST_P(OdometryContract, RefusesImagesThatChangeTheirSize) {
  const auto odometry = make();
  for (const Frame& frame : DriveWorld::frames(3)) odometry->process(frame);
  Frame other = DriveWorld::frame(3);
  other.image = GrayImage(64, 48);
  EXPECT_THROW(odometry->process(other), Error);
}

TEST_P(OdometryContract, FollowsADriveAroundABend) {
  const auto odometry = make();
  run(*odometry, DriveWorld::frames());
  const DriveError error = error_of(*odometry);
  RecordProperty("rotation_deg", fmt::format("{:.3f}", error.rotation_deg));
  RecordProperty("position", fmt::format("{:.4f}", error.position));
  expect_within(error, good);
}

TEST_P(OdometryContract, CameraThatStandsStillGoesNowhere) {
  const auto odometry = make();
  std::vector<Frame> frames(12, DriveWorld::frame(0));
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].index = static_cast<std::int64_t>(k);
    frames[k].stamp = frames[k].depth_stamp = DriveWorld::stamp(static_cast<int>(k));
    Random noise(k);  // or it would be one image repeated
    for (int y = 0; y < frames[k].image.height(); ++y)
      for (int x = 0; x < frames[k].image.width(); ++x)
        frames[k].image.at(x, y) = static_cast<std::uint8_t>(
            std::clamp(std::lround(frames[k].image.at(x, y) + 1.5 * noise.normal()), 0L, 255L));
  }
  run(*odometry, frames);
  for (const StampedPose& pose : odometry->trajectory()) {
    EXPECT_LT(pose.world_from_body.translation().norm(), 0.2 * DriveWorld::step_m);
    EXPECT_LT(pose.world_from_body.rotation().log().norm(), 0.1 * std::numbers::pi / 180.0);
  }
}

TEST_P(OdometryContract, SurvivesNoFrameAndOneFrame) {
  run(*make(), {});
  const auto one = make();
  run(*one, {DriveWorld::frame(0)});
  EXPECT_EQ(text_of(one->trajectory().front().world_from_body), text_of(SE3())) << "the world is the first camera";
}

TEST_P(OdometryContract, CanBeAskedAtAnyTime) {
  const auto asked = make(), alone = make();
  EXPECT_TRUE(asked->trajectory().empty());
  for (const Frame& frame : DriveWorld::frames()) {
    alone->process(frame);
    asked->process(frame);
    EXPECT_EQ(asked->trajectory().size(), static_cast<std::size_t>(frame.index + 1));
  }
  EXPECT_EQ(text_of(asked->trajectory()), text_of(alone->trajectory())) << "asking changed the run";
}

/// One bad frame in place of a good one.
struct Hostile {
  const char* what;
  void (*spoil)(Frame& frame);
  bool of_depth = false;  ///< Nothing but the depth is spoilt.
};

void fill(Frame& frame, std::uint8_t value) {
  for (int y = 0; y < frame.image.height(); ++y) std::fill_n(frame.image.row(y), frame.image.width(), value);
}

void fill_depth(Frame& frame, float meters) {
  for (int y = 0; y < frame.depth.height(); ++y) std::fill_n(frame.depth.row(y), frame.depth.width(), meters);
}

const Hostile hostiles[] = {
    {"nothing at all",
     [](Frame& frame) {
       Frame bare;
       bare.index = frame.index;
       bare.stamp = frame.stamp;
       frame = bare;
     }},
    {"an empty image", [](Frame& frame) { frame.image = {}; }},
    {"black", [](Frame& frame) { fill(frame, 0); }},
    {"white without depth",
     [](Frame& frame) {
       fill(frame, 255);
       frame.depth = {};
     }},
    {"everything masked", [](Frame& frame) { frame.mask = GrayImage(frame.image.width(), frame.image.height()); }},
    {"the stamp before", [](Frame& frame) { frame.stamp -= ns_per_second / 30; }},
    {"a stamp far back", [](Frame& frame) { frame.stamp -= 100 * ns_per_second; }},
    {"no depth image", [](Frame& frame) { frame.depth = {}; }, true},
    {"depth without a measurement", [](Frame& frame) { fill_depth(frame, 0.0F); }, true},
    {"depth that is no number", [](Frame& frame) { fill_depth(frame, std::numeric_limits<float>::quiet_NaN()); }, true},
    {"endless depth", [](Frame& frame) { fill_depth(frame, std::numeric_limits<float>::infinity()); }, true},
    {"depth behind the camera", [](Frame& frame) { fill_depth(frame, -1.0F); }, true},
};

/// Depth reaches only methods that ask for it.
std::vector<Hostile> hostiles_of(const OdometryMethod& method) {
  std::vector<Hostile> chosen;
  for (const Hostile& hostile : hostiles)
    if (!hostile.of_depth || method.wants_depth()) chosen.push_back(hostile);
  return chosen;
}

TEST_P(OdometryContract, SurvivesAnySpoiltFrameAndGoesOn) {
  for (const Hostile& hostile : hostiles_of(*method())) {
    SCOPED_TRACE(hostile.what);
    constexpr int at = 20;
    std::vector<Frame> frames = DriveWorld::frames();
    hostile.spoil(frames[at]);
    const auto odometry = make();
    run(*odometry, frames);
    expect_within(error_of(*odometry, {at}), after_a_fault);
  }
}

TEST_P(OdometryContract, SurvivesARunOfNothingButSpoiltFrames) {
  for (const Hostile& hostile : hostiles_of(*method())) {
    SCOPED_TRACE(hostile.what);
    std::vector<Frame> frames = DriveWorld::frames(12);
    for (Frame& frame : frames) hostile.spoil(frame);
    run(*make(), frames);
  }
}

TEST_P(OdometryContract, SurvivesRepeatedAndMissingFrames) {
  std::vector<Frame> frames = DriveWorld::frames();
  frames.insert(frames.begin() + 15, frames[14]);
  frames.erase(frames.begin() + 28, frames.begin() + 30);
  const auto odometry = make();
  run(*odometry, frames);
  expect_within(error_of(*odometry, {27, 28}), after_a_fault);
}

TEST_P(OdometryContract, GivesTheSameBytesAgainAndForAnyNumberOfThreads) {
  const std::string once = text_of_run(nullptr);
  EXPECT_GT(once.size(), 1000U);
  for (const int threads : {1, 2, 8}) {
    TaskPool pool(threads);
    EXPECT_EQ(text_of_run(&pool), once) << threads << " threads";
  }
}

TEST_P(OdometryContract, KeepsNothingOutsideOfItself) {
  const auto alone = make(), first = make(), second = make();
  for (const Frame& frame : DriveWorld::frames()) alone->process(frame);
  for (int k = 0; k < DriveWorld::frame_count; ++k) {
    first->process(DriveWorld::frame(k));
    if (k > 20) second->process(DriveWorld::frame(k - 20));
  }
  EXPECT_EQ(text_of(first->trajectory()), text_of(alone->trajectory()));
}

/// The limits are meaningful: neither rest nor straight motion at the true speed passes them.
TEST(DriveWorldTest, AGuessWouldNotPass) {
  Trajectory still, straight, exact;
  for (int k = 0; k < DriveWorld::frame_count; ++k) {
    still.push_back({DriveWorld::stamp(k), SE3()});
    straight.push_back({DriveWorld::stamp(k), SE3(SO3(), {0.0, 0.0, DriveWorld::step_m * k})});
    exact.push_back({DriveWorld::stamp(k), DriveWorld::first_from_camera(k)});
  }
  for (const bool is_metric : {false, true}) {
    expect_within(drive_error(exact, is_metric), {1e-6, 1e-6});
    for (const Trajectory* guess : {&still, &straight}) {
      const DriveError error = drive_error(*guess, is_metric);
      EXPECT_GT(error.rotation_deg, 10.0 * after_a_fault.rotation_deg);
      EXPECT_GT(error.position, 1.5 * after_a_fault.position);
    }
  }
}

TEST(OdometryList, HasEveryNameOnceAndNamesTheNearest) {
  std::set<std::string> names;
  for (const auto& method : odometry_methods()) EXPECT_TRUE(names.insert(method->name()).second) << method->name();
  ASSERT_FALSE(names.empty());
  try {
    odometry_method(*names.begin() + "x");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("did you mean '" + *names.begin() + "'"));
  }
}

std::vector<std::string> odometry_names() {
  std::vector<std::string> names;
  for (const auto& method : odometry_methods()) names.push_back(method->name());
  return names;
}

INSTANTIATE_TEST_SUITE_P(Methods, OdometryContract, testing::ValuesIn(odometry_names()),
                         [](const auto& parameter) { return parameter.param; });

}  // namespace
}  // namespace rastro
