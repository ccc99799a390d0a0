// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/fusion/method.h"

#include "rastro/base/error.h"
#include "rastro/map/graph/map.h"
#include "rastro/sensor/stereo_pair.h"
#include "rastro/slam/fusion/options.h"
#include "rastro/slam/fusion/view_alignment.h"
#include "rastro/slam/initial_pose.h"
#include "rastro/slam/orb/orb_slam.h"

namespace rastro {
namespace {

class FusionMethod : public SlamMethod {
 public:
  std::string name() const override { return "fusion"; }
  std::string summary() const override {
    return "stereo or RGB-D SLAM by features, direct alignment and surfaces together: orb, lsd and rgbd in one";
  }
  std::string needs() const override { return "calibrated images with depth, or of a stereo pair"; }
  OptionTable options() override { return option_table(options_); }
  bool wants_depth() const override { return options_.sensor != "stereo"; }
  bool wants_right() const override { return options_.sensor != "rgbd"; }
  bool can_localize() const override { return true; }
  bool can_extend() const override { return true; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (source.cameras.empty() || !source.cameras.front().camera)
      throw Error("has no calibration", source.path, "give one with --calibration FILE");
    FusionOptions options = options_;
    const bool localizes = context.map && !context.extend_map;
    options.orb.sensor = localizes ? sensor_in(*context.map, source) : sensor_of(source);
    const OrbMethodParts parts{name(), [options](const SensorChoice& sensor) {
                                 return std::make_shared<const ViewAlignment>(options, sensor);
                               }};
    return make_with_initial_pose(context, [&](const SlamContext& own_context) {
      return std::make_unique<OrbSlam>(options.orb, source, own_context, parts);
    });
  }

 private:
  /// "rgbd" or "stereo"; Error where the source has neither, or not the one asked for.
  std::string sensor_of(const SourceInfo& source) const {
    if (source.has_depth && (is_any() || options_.sensor == "rgbd")) return "rgbd";
    if (source.has_right && (is_any() || options_.sensor == "stereo")) return "stereo";
    throw Error(
        options_.sensor == "stereo" ? "has no right images" : "has no depth images", source.path,
        "'--method fusion' needs a depth camera, such as a TUM RGB-D folder, or a stereo pair; with one camera it "
        "only localizes in its maps");
  }
  /// To localize in a map, one camera is enough where the recording lacks the sensor of the map.
  std::string sensor_in(const Map& map, const SourceInfo& source) const {
    if (!is_any()) return sensor_of(source);
    const CameraKind made_with = map.cameras.empty() ? CameraKind::mono : map.cameras.front().kind;
    if (made_with == CameraKind::depth && source.has_depth) return "rgbd";
    return made_with == CameraKind::stereo && source.has_right && stereo_pair(source) ? "stereo" : "mono";
  }
  bool is_any() const { return options_.sensor == "auto"; }

  FusionOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> fusion_slam_method() { return std::make_unique<FusionMethod>(); }

}  // namespace rastro
