// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "rastro/feature/stereo_depth.h"
#include "rastro/registration/projective_icp.h"
#include "rastro/slam/fusion/options.h"
#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/tracking/image_alignment.h"
#include "rastro/slam/orb/direct_alignment.h"
#include "rastro/slam/orb/sensor_choice.h"

namespace rastro {

/// What the cost of alignments is about: intensities, and surfaces where depth is measured.
struct AlignedView : DirectView {
  Pyramid image;     ///< Undistorted; what the mask leaves out is black, which counts as clipped.
  GrayImage right;   ///< Of a rectified pair, for the depth of a keyframe; else empty.
  DepthImage depth;  ///< Of a depth camera, as recorded; else empty.
  SE3 depth_from_color;
  DepthBlocks blocks;              ///< Of the depth image; empty without.
  AlignmentReference points;       ///< Of a keyframe.
  std::vector<BlockPlane> planes;  ///< Of a keyframe; empty without depth.
  std::size_t bytes() const override;
};

/// Aligns a frame with a keyframe by intensities (Engel et al. 2014, section 3.3) and by surfaces (point to plane),
/// each weighted by the noise that its residuals show.
class ViewAlignment : public DirectAlignment {
 public:
  ViewAlignment(const FusionOptions& options, const SensorChoice& sensor);
  std::shared_ptr<const DirectView> view_of(const Frame& frame, const SE3& depth_from_color) const override;
  std::shared_ptr<const DirectView> keyframe_of(const DirectView& view) const override;
  std::optional<RelativePose> align(const DirectView& keyframe, const DirectView& view,
                                    const SE3& camera_from_keyframe_guess) const override;

 private:
  InverseDepthMap depths_of(const AlignedView& view) const;
  RelativePose judged(const RelativePose& by_image, const RelativePose& joint) const;
  std::optional<RelativePose> by_intensities(const AlignedView& keyframe, const AlignedView& view,
                                             const SE3& guess) const;
  std::optional<RelativePose> with_surfaces(const AlignedView& keyframe, const AlignedView& view,
                                            const RelativePose& start) const;

  FusionOptions options_;
  SensorChoice sensor_;
  LsdFrameMaker undistorted_;
  Camera camera_;                          ///< Of the undistorted images.
  std::optional<ProjectiveIcp> surfaces_;  ///< Only of a depth camera.
  std::optional<StereoDepth> stereo_;
  ImageAlignmentOptions image_options_;
};

}  // namespace rastro
