// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/rgbd_slam.h"

#include "rastro/backend/rgbd/given_map.h"
#include "rastro/backend/rgbd/rgbd_session.h"

namespace rastro {

RgbdSlam::RgbdSlam(const std::string& method, const RgbdSlamOptions& options, const Camera& camera,
                   const SlamContext& context, MakeSearch make_search, double baseline)
    : options_(options),
      camera_(camera),
      context_(with_usable_map(context, camera, options)),
      method_(method),
      make_search_(std::move(make_search)),
      baseline_(baseline),
      session_(new_session()) {}
RgbdSlam::~RgbdSlam() = default;
SlamUpdate RgbdSlam::process(const Frame& frame) { return session_->process(frame); }
std::vector<SlamEvent> RgbdSlam::finish() { return session_->finish(); }
Trajectory RgbdSlam::trajectory() const { return session_->trajectory(); }
std::shared_ptr<const Map> RgbdSlam::snapshot() const { return session_->snapshot(); }
bool RgbdSlam::set_mapping(bool on) { return session_->set_mapping(on); }
std::vector<FeatureObservation> RgbdSlam::observations() const { return session_->observations(); }
std::int64_t RgbdSlam::dropped_frames() const { return session_->dropped_frames(); }
MapMemory RgbdSlam::map_memory() const { return session_->map_memory(); }
std::vector<PlaceBelief> RgbdSlam::places() const { return session_->places(); }

void RgbdSlam::reset() {
  session_.reset();  // its jobs end before the next ones begin
  session_ = new_session();
}

std::unique_ptr<RgbdSession> RgbdSlam::new_session() const {
  return std::make_unique<RgbdSession>(
      options_, camera_, context_, RgbdSession::Method{method_, make_search_ ? make_search_() : nullptr, baseline_});
}

}  // namespace rastro
