// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/epipolar_search.h"

#include <Eigen/Core>
#include <cstddef>

namespace rastro {

EpipolarSearch::EpipolarSearch(GrayView keyframe, GrayView image, const Camera& camera, const SE3& image_from_keyframe,
                               double gain, double offset, const EpipolarSearchOptions& options) {
  const auto real = [](double value) { return static_cast<float>(value); };
  view_.keyframe = keyframe, view_.image = image;
  const Eigen::Matrix3d rotation = image_from_keyframe.rotation().matrix();
  const Eigen::Vector3d translation = image_from_keyframe.translation(), center = -(rotation.transpose() * translation);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) view_.rotation[3 * row + column] = real(rotation(row, column));
    view_.translation[row] = real(translation[row]);
    view_.center[row] = real(center[row]);
  }
  view_.fx = real(camera.fx), view_.fy = real(camera.fy), view_.cx = real(camera.cx), view_.cy = real(camera.cy);
  view_.gain = real(gain), view_.offset = real(offset);
  const double noise = 2.0 * options.intensity_sigma * options.intensity_sigma;
  view_.min_line_px = real(options.min_line_px);
  view_.half_length_px = real(0.5 * options.max_length_px);
  view_.min_gradient = real(options.min_gradient * gain);
  view_.intensity_variance = real(noise);
  view_.most_residual = real(options.max_residual_sigmas * options.max_residual_sigmas * noise);
  view_.squared_second_ratio = real(options.min_second_ratio * options.min_second_ratio);
  view_.disparity_sigma_px = real(options.disparity_sigma_px);
  view_.geometry_variance = real(options.geometry_sigma_px * options.geometry_sigma_px);
}

EpipolarMatch EpipolarSearch::find(int x, int y, const DepthPrior& prior) const { return find_one(*this, x, y, prior); }

void add_query(int x, int y, const DepthPrior& prior, EpipolarQueries& queries) {
  const auto i = static_cast<std::size_t>(queries.count++);
  queries.x[i] = static_cast<float>(x), queries.y[i] = static_cast<float>(y);
  queries.least[i] = static_cast<float>(prior.least);
  queries.expected[i] = static_cast<float>(prior.expected);
  queries.most[i] = static_cast<float>(prior.most);
  queries.worthwhile_variance[i] = static_cast<float>(prior.worthwhile_variance);
}

EpipolarMatch match_at(const EpipolarMatches& matches, int index) {
  const auto i = static_cast<std::size_t>(index);
  const auto result = static_cast<EpipolarResult>(matches.result[i]);
  return result == EpipolarResult::matched ? EpipolarMatch{result, matches.mean[i], matches.variance[i]}
                                           : EpipolarMatch{result};
}

}  // namespace rastro
