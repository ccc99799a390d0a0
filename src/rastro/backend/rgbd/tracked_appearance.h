// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "rastro/backend/rgbd/appearance_check.h"
#include "rastro/base/time.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Whether what tracking finds after a gap looks like it. While an image comes every few hundredths of a second, the
/// camera is where the motion before takes it. After a loss, or with an image every half second, tracking may end on
/// another step of a stair, where features and surfaces fit as well; the rest of the image then looks different.
class TrackedAppearance {
 public:
  explicit TrackedAppearance(const AppearanceCheck& check) : check_(check) {}

  /// What the frames that follow are compared with; without depth, they are not.
  void keep(const Frame& keyframe);
  void forget() { keyframe_ = nullptr; }
  /// A pose was found that was no prediction.
  void note(TimeNs stamp) { found_ = stamp; }
  /// What both show, where a gap ends with this frame and most of it hardly looks alike; nullopt else.
  std::optional<AppearanceAgreement> contradiction(const Frame& frame, const SE3& keyframe_from_frame) const;

 private:
  const AppearanceCheck& check_;
  std::shared_ptr<const Frame> keyframe_;
  TimeNs found_ = 0;
};

/// Of a pose that may be that of something alike, as (translation m, rotation rad).
Matrix6d look_alike_covariance();

}  // namespace rastro
