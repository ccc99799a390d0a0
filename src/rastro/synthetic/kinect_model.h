// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/base/task_pool.h"
#include "rastro/image/image.h"

namespace rastro {

class Renderer;
class SE3;
struct RenderedFrame;

/// Error model of a depth camera that matches a projected pattern (Khoshelham and Elberink 2012; Nguyen, Izadi and
/// Lovell 2012). It measures the disparity d = f b / z between its infrared camera and a projector to its right, in
/// steps.
struct KinectModel {
  double baseline_m = 0.075;       ///< b; f is that of the color camera, in which depth is given.
  double step_px = 0.125;          ///< Disparities are rounded to multiples of it.
  double fine_noise_px = 0.045;    ///< Standard deviation of the disparity, from pixel to pixel
  double coarse_noise_px = 0.035;  ///< and over patches of `patch_px`.
  int patch_px = 8;
  double nearest_m = 0.45, farthest_m = 8.0;  ///< Outside this range there is no depth.
  double steepest = 6.0;  ///< Tangent of the incidence angle above which a surface returns too little light.
  /// Share of the patches of a glass sheet without depth; the others have the depth behind it.
  double glass_lost = 0.55;
  double delay_s = 0.012;           ///< Delay of the depth image after the color image.
  double units_per_meter = 5000.0;  ///< Of the written images; 0 is no measurement.
};

/// The depth camera's image of an exact one (Renderer::cast), in units of the model. Holes are where the projector does
/// not reach (a band to the left of objects in front), sometimes at depth edges, on steep, dark and glass surfaces, and
/// outside the range. `noise_seed` must differ between frames. The same bytes for any pool.
Image<std::uint16_t> kinect_depth(const RenderedFrame& exact, const Renderer& renderer, const SE3& world_from_camera,
                                  const KinectModel& model, std::uint64_t noise_seed, TaskPool& pool);

}  // namespace rastro
