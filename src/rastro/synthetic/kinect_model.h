// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/base/task_pool.h"
#include "rastro/image/image.h"

namespace rastro {

class Renderer;
class SE3;
struct RenderedFrame;

/// How a depth camera that matches a projected pattern goes wrong (Khoshelham and Elberink 2012; Nguyen, Izadi and
/// Lovell 2012). It measures the disparity d = f b / z between its infrared camera and a projector to its right, in
/// steps.
struct KinectModel {
  double baseline_m = 0.075;       ///< b; f is that of the colour camera, which depth is given in.
  double step_px = 0.125;          ///< Disparities are rounded to multiples of it.
  double fine_noise_px = 0.045;    ///< Standard deviation of the disparity, from pixel to pixel
  double coarse_noise_px = 0.035;  ///< and over patches of `patch_px`.
  int patch_px = 8;
  double nearest_m = 0.45, farthest_m = 8.0;  ///< Outside of this nothing is measured.
  double steepest = 6.0;     ///< Tangent of the angle from where on a surface begins to send too little light back.
  double glass_lost = 0.55;  ///< Share of the patches of a glass sheet without depth; the others have what lies behind.
  double delay_s = 0.012;    ///< A depth picture is taken so much after the colour picture.
  double units_per_metre = 5000.0;  ///< Of the pictures written; 0 is no measurement.
};

/// The depth camera's picture of an exact one (Renderer::cast), in units of the model. Holes are where the projector
/// does not reach (a band to the left of what stands in front), at edges of depth now and then, on steep, dark and
/// glass surfaces, and outside of the range. `noise_seed` must differ between frames. The same bytes for any pool.
Image<std::uint16_t> kinect_depth(const RenderedFrame& exact, const Renderer& renderer, const SE3& world_from_camera,
                                  const KinectModel& model, std::uint64_t noise_seed, TaskPool& pool);

}  // namespace rastro
