// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/feature/orb.h"
#include "rastro/input_check/input_warning.h"
#include "rastro/input_check/sample_schedule.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// Checks a calibrated stereo pair by matches between its images: their order, their time, their rectification, and
/// the length of the baseline.
class StereoCheck {
 public:
  explicit StereoCheck(const SourceInfo& info);

  /// Adds what is sure since this frame to `found`, each kind once.
  void add(const Frame& frame, InputWarnings& found);

 private:
  /// Features of an image in rectified coordinates: pixels of a camera with the left one's focal length.
  struct View {
    Features features;
    std::vector<Eigen::Vector2d> rectified;
  };
  struct Pair {
    View left, right;
  };
  /// Matches between a left and a right image.
  struct Comparison {
    int matches = 0, positive = 0, negative = 0;  ///< By the sign of a clear disparity.
    double vertical_px = 0.0;                     ///< Median of the vertical disparities' sizes.
    double shift_px = 0.0;                        ///< Median of the vertical disparities.
  };
  struct Sample {
    Comparison same, right_late, right_early;
  };

  View view_of(const GrayImage& image, const Camera& camera, const SO3& camera_from_rectified);
  static Comparison compare(const View& left, const View& right);
  void judge(InputWarnings& found);
  bool judge_time(InputWarnings& found);
  bool judge_order(InputWarnings& found);
  void judge_rectification(InputWarnings& found);
  void judge_baseline(InputWarnings& found);

  std::optional<Camera> left_, right_;  ///< Unset: there is no calibrated pair.
  double baseline_m_ = 0.0;
  bool baseline_judged_ = false, said_ = false;
  std::int64_t number_ = 0;
  SO3 left_from_rectified_, right_from_rectified_;
  SampleSchedule schedule_;
  OrbExtractor extractor_;
  std::optional<Pair> last_;
  std::vector<Sample> samples_;
};

}  // namespace rastro
