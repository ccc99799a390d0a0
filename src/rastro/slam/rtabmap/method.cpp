// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rtabmap/method.h"

#include <optional>
#include <utility>

#include "rastro/backend/rgbd/rgbd_slam.h"
#include "rastro/base/error.h"
#include "rastro/slam/initial_pose.h"
#include "rastro/slam/rtabmap/appearance_search.h"
#include "rastro/slam/rtabmap/options.h"
#include "rastro/slam/rtabmap/stereo_slam.h"

namespace rastro {
namespace {

class RtabmapMethod : public SlamMethod {
 public:
  std::string name() const override { return "rtabmap"; }
  std::string summary() const override {
    return "appearance-based SLAM with memory management, after RTAB-Map (Labbe and Michaud 2013, 2014)";
  }
  std::string needs() const override { return "calibrated images with depth, or of a stereo pair"; }
  OptionTable options() override { return option_table(options_); }
  std::vector<std::string> presets() const override { return {"paper"}; }
  void set_preset(const std::string&) override { set_paper_preset(options_); }
  bool wants_color() const override { return true; }
  bool wants_depth() const override { return options_.sensor != "stereo"; }
  bool wants_right() const override { return options_.sensor != "rgbd"; }
  bool can_localize() const override { return true; }
  bool can_extend() const override { return true; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (source.cameras.empty() || !source.cameras.front().camera)
      throw Error("has no calibration", source.path, "give one with --calibration FILE");
    const auto pair = pair_of(source);
    const RgbdSlamOptions tracking = pair ? stereo_options(*pair) : options_.rgbd;
    return make_with_initial_pose(context, [&](const SlamContext& own_context) -> std::unique_ptr<Slam> {
      const auto search = [options = options_, means = AppearanceSearch::Means{own_context.pool, own_context.live}] {
        return std::make_unique<AppearanceSearch>(options, means);
      };
      const Camera& camera = pair ? pair->camera : *source.cameras.front().camera;
      const double baseline = pair ? pair->baseline : 0.0;
      auto slam = std::make_unique<RgbdSlam>(name(), tracking, camera, own_context, search, baseline);
      if (!pair) return slam;
      const int max_disparity_px = options_.stereo_max_disparity_px;
      return std::make_unique<StereoSlam>(*pair, StereoRange{options_.stereo_min_disparity_px, max_disparity_px},
                                          own_context.pool, std::move(slam));
    });
  }

 private:
  /// The pair to use; nullopt: depth images. Error where the source has neither.
  std::optional<StereoPair> pair_of(const SourceInfo& source) const {
    if (source.has_depth && options_.sensor != "stereo") return std::nullopt;
    if (options_.sensor == "rgbd" || !source.has_right)
      throw Error(options_.sensor == "stereo" ? "has no right images" : "has no depth images", source.path,
                  "'--method rtabmap' needs a depth camera, such as a TUM RGB-D folder, or a stereo pair");
    auto pair = stereo_pair(source);
    if (!pair)
      throw Error("has stereo images without calibration of both cameras, or of cameras that are not side by side",
                  source.path, "give --calibration FILE");
    return pair;
  }

  /// Depth z has the disparity f b / z, so that its sigma grows with its square. What is not at its default stays.
  RgbdSlamOptions stereo_options(const StereoPair& pair) const {
    RgbdSlamOptions options = options_.rgbd;
    const RgbdOptions usual = RtabmapOptions().rgbd.follow;
    const auto follow = [&](auto member, const auto& value) {
      if (options.follow.*member == usual.*member) options.follow.*member = value;
    };
    const double focal_times_baseline = pair.camera.fx * pair.baseline;
    follow(&RgbdOptions::depth_sigma_m, 0.0);
    follow(&RgbdOptions::depth_sigma_per_m2, options_.stereo_sigma_px / focal_times_baseline);
    follow(&RgbdOptions::min_depth_m, focal_times_baseline / options_.stereo_max_disparity_px);
    follow(&RgbdOptions::max_depth_m, focal_times_baseline / options_.stereo_min_disparity_px);
    constexpr double usual_sigma = 0.06;  // of poses from stereo depth where all is well
    follow(&RgbdOptions::weak_sigma, usual_sigma);
    follow(&RgbdOptions::learn_delay, false);  // both images are of one instant
    // Where there is no texture, semi-global matching assumes smooth surfaces: no measurement to track by. A camera
    // that stands still would move with their noise.
    follow(&RgbdOptions::surfaces, "off");
    return options;
  }

  RtabmapOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> rtabmap_slam_method() { return std::make_unique<RtabmapMethod>(); }

}  // namespace rastro
