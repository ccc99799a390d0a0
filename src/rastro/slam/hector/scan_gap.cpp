// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/scan_gap.h"

#include <algorithm>

namespace rastro {

/// What is new fits as well anywhere else: what carried the pose over the gap is the guess.
std::optional<ScanGap> gap_before(double seconds, const ScanGuess& guess, const FollowedScan& followed) {
  constexpr double known_place = 0.75;  // the score where most of a scan was mapped before
  if (seconds == 0.0 || !followed.fits || followed.score >= known_place) return std::nullopt;
  // Odometry gathers errors on the whole way, of which only the ends are known.
  constexpr double drift_m_per_s = 0.05, drift_rad_per_s = 0.005;
  const double sigma_m = std::max(guess.sigma_m, drift_m_per_s * seconds);
  const Eigen::Vector3d sigma(sigma_m, sigma_m, std::max(guess.sigma_rad, drift_rad_per_s * seconds));
  // The match with the little that was mapped may be wrong; then the robot is where the guess was.
  const SE2 &guessed = guess.local_from_body, &fitted = followed.local_from_body;
  Eigen::Vector3d moved;
  moved << fitted.translation() - guessed.translation(), (guessed.rotation().inverse() * fitted.rotation()).angle();
  ScanGap gap{seconds, sigma.cwiseAbs2().asDiagonal()};
  gap.covariance += moved * moved.transpose();
  return gap;
}

}  // namespace rastro
