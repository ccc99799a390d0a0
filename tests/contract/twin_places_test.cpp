// SPDX-License-Identifier: Apache-2.0
// Perceptual aliasing: two places that look alike must not be closed as a loop, which would deform the whole map.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "accuracy_testing.h"
#include "rastro/methods/methods.h"
#include "twin_testing.h"

namespace rastro {
namespace {

struct TwinCase {
  const char* method;
  const char* sensor;
  double worst_m;  ///< Of any pose; about one and a half times what was measured.
};

void PrintTo(const TwinCase& twin, std::ostream* out) { *out << twin.method << '_' << twin.sensor; }

std::unique_ptr<TestRecording> twin_recording(const TwinCase& twin) {
  if (std::string(twin.sensor) == "laser") return std::make_unique<TwinRooms>();
  return std::make_unique<TwinPassage>(twin.sensor);
}

std::unique_ptr<Slam> make_slam(const TwinCase& twin, const TestRecording& recording) {
  const auto method = slam_method(twin.method);
  OptionTable table = method->options();
  for (const Option& option : table.options()) {
    if (option.name == "sensor") table.set("sensor", twin.sensor, "a test");
  }
  return method->make(recording.info(), {});
}

class TwinPlaces : public testing::TestWithParam<TwinCase> {};

/// Loop closures and merges of a camera's map between keyframes that never observed the same wall, as text. (A laser
/// observes the other room through the door.)
std::string false_edges(const Map& map, const TestRecording& recording) {
  constexpr double sees_m = 2.5;
  std::string text;
  for (const Constraint& constraint : map.constraints) {
    const auto a = frame_of(recording, map.find(constraint.from)->stamp);
    const auto b = frame_of(recording, map.find(constraint.to)->stamp);
    const bool found_again = constraint.kind == ConstraintKind::loop || constraint.kind == ConstraintKind::merge;
    if (!found_again || !a || !b || recording.info().has_scan) continue;
    const double separation_m =
        (recording.world_from_body(*a).translation() - recording.world_from_body(*b).translation()).norm();
    if (separation_m > sees_m) text += fmt::format(" {}-{} ({:.1f} m)", *a, *b, separation_m);
  }
  return text;
}

TEST_P(TwinPlaces, AreNotMerged) {
  const TwinCase& twin = GetParam();
  const auto recording = twin_recording(twin);
  const auto slam = make_slam(twin, *recording);
  for (int k = 0; k < recording->frame_count(); ++k) slam->process(recording->frame(k));
  slam->finish();
  const std::string false_merges = false_edges(*slam->snapshot(), *recording);
  const double worst_m = worst_error_m(slam->trajectory(), *recording);
  RecordProperty("worst_m", fmt::format("{:.4f}", worst_m));
  EXPECT_GE(slam->trajectory().size() * 10, static_cast<std::size_t>(recording->frame_count()) * 9);
  EXPECT_EQ(false_merges, "") << "frames that were taken for one place";
  EXPECT_LT(worst_m, twin.worst_m);
}

INSTANTIATE_TEST_SUITE_P(Methods, TwinPlaces,
                         testing::Values(TwinCase{"hector", "laser", 0.13}, TwinCase{"ekf", "laser", 0.18},
                                         TwinCase{"rgbd", "rgbd", 0.2}, TwinCase{"orb", "rgbd", 0.04},
                                         TwinCase{"orb", "stereo", 0.06}, TwinCase{"orb", "mono", 0.04}),
                         [](const auto& parameter) {
                           return std::string(parameter.param.method) + "_" + parameter.param.sensor;
                         });

}  // namespace
}  // namespace rastro
