// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "rastro/optimize/board_adjustment.h"

namespace rastro {

/// Start of one camera: a lens without distortion, and the pose of each view.
struct BoardStart {
  Lens lens;
  std::vector<std::optional<SE3>> camera_from_board;  ///< Per view; nullopt where no pose explains it.
  double median_rms_px = 0.0;                         ///< Over the views.
};

/// The focal length, of a geometric series from 0.25 to 5 times the larger side of the image, at which the median view
/// is explained best by a pose (Collins and Bartoli 2014, IPPE, for each view). Views that are wrong move no median.
/// `views` of one camera.
BoardStart start_boards(const std::vector<Eigen::Vector2d>& board, const std::vector<const BoardView*>& views,
                        LensModel model, int width, int height);

/// The pose that explains a view best with this lens; nullopt where none does.
std::optional<SE3> board_pose(const std::vector<Eigen::Vector2d>& board, const BoardView& view, const Lens& lens);

}  // namespace rastro
