// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"
#include "rastro/slam/lsd/depth/epipolar_kernels.h"

namespace rastro {

struct EpipolarSearchOptions {
  double intensity_sigma = 3.0;      ///< Of one image, intensity levels.
  double geometry_sigma_px = 0.4;    ///< Of the epipolar line's position: pose and calibration.
  double disparity_sigma_px = 0.1;   ///< Least, of the parabola and of what all frames have in common.
  double min_line_px = 1.0;          ///< Shift by the inverse depth that is expected, at least.
  double min_gradient = 3.0;         ///< Along the line, intensity levels per pixel.
  double max_length_px = 40.0;       ///< Searched.
  double max_residual_sigmas = 3.0;  ///< Root mean square of the five samples.
  double min_second_ratio = 1.5;     ///< Of the residual of another minimum to the best one's.
  double max_inverse_depth = 10.0;   ///< Where nothing is known: as a multiple of the mean.
};

enum class EpipolarResult : std::uint8_t {
  matched,
  outside,     ///< The line leaves the image.
  short_line,  ///< Too little motion.
  flat,        ///< Too little gradient along the line.
  poor_match,  ///< Nothing on the line looks like the pixel.
  ambiguous,   ///< More than one place does.
  behind,      ///< Of the camera.
  no_news,     ///< It would be less certain than what is worth a search.
};
constexpr int epipolar_results = 8;

/// What is known of a pixel's inverse depth before.
struct DepthPrior {
  double least = 0.0, expected = 1.0, most = 1.0;
  bool is_known = false;  ///< Else an ambiguous match is none.
  /// Larger variances are not worth a search.
  double worthwhile_variance = std::numeric_limits<double>::infinity();
};

struct EpipolarMatch {
  EpipolarResult result = EpipolarResult::matched;
  float mean = 0.0F, variance = 0.0F;  ///< Of the inverse depth.
};

/// Finds pixels of a keyframe along their epipolar lines in another image, by five equidistant samples (Engel et al.
/// 2013, section 2.1); the variance is that of equations 6 to 13 there: geometric and photometric disparity errors,
/// propagated to the inverse depth.
class EpipolarSearch {
 public:
  /// Intensity in the image = gain * intensity in the keyframe + offset. Both outlive this.
  EpipolarSearch(GrayView keyframe, GrayView image, const Camera& camera, const SE3& image_from_keyframe, double gain,
                 double offset, const EpipolarSearchOptions& options);
  /// Nothing is found where it is zero; empty: everywhere.
  void leave_out(GrayView mask) { view_.mask = mask; }
  /// The same bytes for any SIMD level and whatever else is in the batch.
  void find(const EpipolarQueries& queries, EpipolarMatches& matches) const {
    epipolar_kernels().search(view_, queries, matches);
  }
  EpipolarMatch find(int x, int y, const DepthPrior& prior) const;

 private:
  EpipolarView view_;
};

/// Appends a pixel; the batch must have room.
void add_query(int x, int y, const DepthPrior& prior, EpipolarQueries& queries);
EpipolarMatch match_at(const EpipolarMatches& matches, int index);

/// A search of batches, for a single pixel.
template <typename Search>
EpipolarMatch find_one(const Search& search, int x, int y, const DepthPrior& prior) {
  EpipolarQueries queries;
  EpipolarMatches matches;
  queries.known = prior.is_known;
  add_query(x, y, prior, queries);
  search.find(queries, matches);
  return match_at(matches, 0);
}

}  // namespace rastro
