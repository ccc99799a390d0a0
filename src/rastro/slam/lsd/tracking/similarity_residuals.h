// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/math/sim3.h"
#include "rastro/slam/lsd/tracking/affine_brightness.h"
#include "rastro/slam/lsd/tracking/alignment_reference.h"
#include "rastro/slam/lsd/tracking/levenberg_marquardt.h"

namespace rastro {

/// Translation, rotation, log of the scale, gain, offset.
constexpr int similarity_unknowns = 9;

struct SimilarityState {
  Sim3 b_from_a;
  AffineBrightness brightness;
};

/// What a point of keyframe a measures in keyframe b.
struct SimilarityResidual {
  using Row = Eigen::Matrix<double, 1, similarity_unknowns>;

  bool inside = false;                                       ///< It projects into b.
  bool used = false;                                         ///< Where the intensity is not clipped.
  bool has_depth = false;                                    ///< Where the inverse depth of b is known.
  double intensity = 0.0, intensity_variance = 1.0;          ///< Levels: in b less that predicted from a.
  double inverse_depth = 0.0, inverse_depth_variance = 1.0;  ///< Unit of b: predicted from a less that of b.
  Row by_state_intensity = Row::Zero(), by_state_inverse_depth = Row::Zero();

  /// Sum of both in squared standard deviations.
  double squared_error() const;
};

/// One level of a similarity alignment as a problem of minimize().
class SimilarityResiduals {
 public:
  using State = SimilarityState;
  using Step = Eigen::Matrix<double, similarity_unknowns, 1>;
  struct Linear : Linearization<similarity_unknowns> {
    std::vector<Step> scores;  ///< Gradient of each chunk of neighboring points.
    double cost_sum = 0.0, squares = 0.0;
    int inside = 0, used = 0, with_depth = 0, inliers = 0;
  };

  /// `fix_scale`: no step changes it, and the hessian says that it is known.
  SimilarityResiduals(const AlignmentPoints& points, const PaddedImage& image, const InverseDepthMap& depth,
                      const PhotometricNoise& noise, bool fix_scale = false)
      : points_(points), image_(image), depth_(depth), noise_(noise), fix_scale_(fix_scale) {}

  SimilarityResidual residual(int point, const State& state) const;
  Linear linearize(const State& state) const;
  static State retract(const State& state, const Step& step);
  /// How far a point at mean depth moves, at most; a step in scale counts as one in depth.
  double step_px(const Step& step) const;

 private:
  struct Motion;
  struct Projected;
  SimilarityResidual residual(int point, const Motion& motion) const;
  void set_intensity(const Projected& projected, const Motion& motion, SimilarityResidual& result) const;
  void set_inverse_depth(const Projected& projected, const Motion& motion, SimilarityResidual& result) const;
  static void hold_scale(Linear& linear);
  void add(const SimilarityResidual& residual, Step& score, Linear& linear) const;

  const AlignmentPoints& points_;
  const PaddedImage& image_;
  const InverseDepthMap& depth_;
  PhotometricNoise noise_;
  bool fix_scale_;
};

}  // namespace rastro
