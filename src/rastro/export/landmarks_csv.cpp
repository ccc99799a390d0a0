// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/landmarks_csv.h"

#include <fmt/format.h>

namespace rastro {

std::string landmarks_csv(const LandmarkLayer& layer) {
  std::string text = "id,sensor_id,x,y,cov_xx,cov_xy,cov_yy,observations\n";
  for (std::size_t k = 0; k < layer.estimates.size() && k < layer.landmarks.size(); ++k) {
    const Landmark& landmark = layer.landmarks[k];
    const LandmarkEstimate& estimate = layer.estimates[k];
    text += fmt::format("{},{},{:.6f},{:.6f},{:.6g},{:.6g},{:.6g},{}\n", landmark.id, estimate.sensor_id,
                        landmark.position.x(), landmark.position.y(), estimate.covariance(0, 0),
                        estimate.covariance(0, 1), estimate.covariance(1, 1), estimate.observations);
  }
  return text;
}

}  // namespace rastro
