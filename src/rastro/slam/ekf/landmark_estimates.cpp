// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/landmark_estimates.h"

#include <algorithm>
#include <vector>

namespace rastro {

std::shared_ptr<const LandmarkLayer> landmark_estimates(const EkfFilter& filter,
                                                        std::span<const LandmarkRecord> records) {
  auto layer = std::make_shared<LandmarkLayer>();
  std::vector<std::size_t> confirmed;
  for (std::size_t i = 0; i < records.size(); ++i)
    if (!records[i].is_candidate()) confirmed.push_back(i);
  std::sort(confirmed.begin(), confirmed.end(),
            [&](std::size_t a, std::size_t b) { return records[a].id < records[b].id; });
  for (const std::size_t i : confirmed) {
    Landmark& landmark = layer->landmarks.emplace_back();
    landmark.id = records[i].id;
    landmark.position.head<2>() = filter.landmark(i);
    LandmarkEstimate& estimate = layer->estimates.emplace_back();
    estimate.sensor_id = records[i].sensor_id;
    estimate.observations = records[i].observations;
    estimate.covariance.setZero();
    estimate.covariance.topLeftCorner<2, 2>() = filter.landmark_covariance(i);
  }
  return layer;
}

}  // namespace rastro
