// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/rgbd_slam.h"

#include "rastro/slam/rgbd/given_map.h"
#include "rastro/slam/rgbd/rgbd_session.h"

namespace rastro {

RgbdSlam::RgbdSlam(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context)
    : options_(options),
      camera_(camera),
      context_(with_usable_map(context, camera)),
      session_(std::make_unique<RgbdSession>(options, camera, context_)) {}
RgbdSlam::~RgbdSlam() = default;
SlamUpdate RgbdSlam::process(const Frame& frame) { return session_->process(frame); }
std::vector<SlamEvent> RgbdSlam::finish() { return session_->finish(); }
Trajectory RgbdSlam::trajectory() const { return session_->trajectory(); }
std::shared_ptr<const Map> RgbdSlam::snapshot() const { return session_->snapshot(); }
bool RgbdSlam::set_mapping(bool on) { return session_->set_mapping(on); }
std::vector<FeatureObservation> RgbdSlam::observations() const { return session_->observations(); }
std::int64_t RgbdSlam::dropped_frames() const { return session_->dropped_frames(); }
MapMemory RgbdSlam::map_memory() const { return session_->map_memory(); }

void RgbdSlam::reset() {
  session_.reset();  // its jobs end before the next ones begin
  session_ = std::make_unique<RgbdSession>(options_, camera_, context_);
}

}  // namespace rastro
