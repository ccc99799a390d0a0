// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/landmarks_csv.h"

#include <fmt/format.h>

namespace rastro {

std::string landmarks_csv(const std::vector<PlanarLandmark>& landmarks) {
  std::string text = "id,sensor_id,x,y,cov_xx,cov_xy,cov_yy,observations\n";
  for (const PlanarLandmark& landmark : landmarks) {
    text += fmt::format("{},{},{:.6f},{:.6f},{:.6g},{:.6g},{:.6g},{}\n", landmark.id, landmark.sensor_id,
                        landmark.position.x(), landmark.position.y(), landmark.covariance(0, 0),
                        landmark.covariance(0, 1), landmark.covariance(1, 1), landmark.observations);
  }
  return text;
}

}  // namespace rastro
