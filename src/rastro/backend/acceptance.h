// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// How far a recognized place has been accepted.
enum class HypothesisState : std::uint8_t {
  candidate,    ///< Proposed; not verified yet.
  unconfirmed,  ///< Verified, but by too few frames or keyframes.
  accepted,     ///< Verified and confirmed.
  rejected,     ///< Rejection says why.
};
const char* name_of(HypothesisState state);  ///< "candidate", "unconfirmed", ...

/// Why a hypothesis is not accepted; the first that applies, in this order.
enum class Rejection : std::uint8_t {
  none,
  low_score,           ///< The method's own score is too low.
  few_inliers,         ///< Too few matches fit one pose.
  low_inlier_share,    ///< Too small a share of the matches fits one pose.
  few_observed,        ///< Too few landmarks are found where the hypothesis predicts them.
  near_chance,         ///< Too few beside those found under a wrong hypothesis.
  low_overlap,         ///< Too little of what was compared can be judged at all.
  low_observed_share,  ///< Negative evidence: what should be visible and is not occluded is not observed.
  looks_different,     ///< What has the right shape shows something else.
  contradicts_graph,   ///< Inconsistent with odometry or the rest of the graph.
  not_confirmed,       ///< The following frames or keyframes did not recognize the place again.
};
const char* name_of(Rejection rejection);  ///< "none", "low_score", ...

/// What a method knows about a hypothesis. Values it leaves out are not judged while their limit is off.
struct Evidence {
  double score = 1.0;            ///< Likelihood or similarity, 0..1.
  int matches = 0;               ///< Of features or landmarks, correct or not.
  int inliers = 0;               ///< Of these, those that fit one pose.
  int compared = 0;              ///< Landmarks, depths or beams compared with the map.
  int predicted = 0;             ///< Of these, those that the hypothesis predicts to be visible and not occluded.
  int observed = 0;              ///< Of these, those observed where they are predicted.
  double chance_observed = 0.0;  ///< The same to be expected of a wrong hypothesis.
  int patches = 0;               ///< Textured patches of surfaces that both views show.
  int alike_patches = 0;         ///< Of these, those that look alike.
  /// Distance between the hypothesis and the graph's prediction, in standard deviations: graph_sigmas().
  double graph_sigmas = 0.0;

  /// Share of the predicted that is observed; 0 if nothing is.
  double observed_share() const { return observed == 0 ? 0.0 : static_cast<double>(observed) / predicted; }
  /// Share of the compared that could be judged; 0 if nothing is observed.
  double overlap() const { return observed == 0 ? 0.0 : static_cast<double>(predicted) / compared; }
  /// Share of the patches that looks alike, at least, with 95 % confidence (Wilson 1927): few patches prove little.
  double alike_share() const;
  /// At most, in the same sense: 1 without patches, which contradict nothing.
  double most_alike_share() const;
};

/// Limits for one use (loops, merges, relocalization, continuation of a map). By default each is off.
struct AcceptanceOptions {
  double min_score = 0.0;
  int min_inliers = 0;
  double min_inlier_share = 0.0;    ///< Of the matches.
  int min_observed = 0;             ///< Landmarks found where they are predicted.
  double min_chance_ratio = 0.0;    ///< Of these to those found under a wrong hypothesis.
  double min_overlap = 0.0;         ///< Of what was compared.
  double min_observed_share = 0.0;  ///< Of what is predicted; a smaller share is negative evidence and rejects.
  double min_alike_share = 0.0;     ///< Of the patches, see Evidence::alike_share().
  double max_graph_sigmas = std::numeric_limits<double>::infinity();
  int min_confirmations = 1;  ///< Consecutive frames or keyframes that must recognize it; 1: accepts the first.
  int max_missed = 0;         ///< Frames or keyframes between them that may miss it.
};

/// Judges the evidence alone, without earlier frames. NaN never passes a limit that is on.
Rejection judge(const Evidence& evidence, const AcceptanceOptions& options);

/// The hypothesis that a frame or keyframe shows a place of the map. Its state follows from its members, whatever their
/// order of arrival.
struct Hypothesis {
  std::int64_t place = 0;  ///< Keyframe or submap, by the method's own number.
  /// The place and its neighbors, ascending. A hypothesis of the next frame that shares one of them is the same.
  std::vector<std::int64_t> group = {place};
  int confirmations = 1;   ///< Consecutive frames or keyframes that recognized it, including this one.
  bool confirmed = false;  ///< By as many as required.
  bool verified = false;   ///< Evidence was judged, and sufficient unless rejected.
  Rejection rejection = Rejection::none;

  HypothesisState state() const;
};

/// Decides which hypotheses of recognized places to accept, from one frame or from several in a row. A value: copies
/// are independent, and the same calls give the same decisions.
///
/// Consistency over time is that of Mur-Artal et al. 2015, section VII.A, for any groups of places. The method chooses
/// whether a place is verified before it is confirmed (relocalization: only verified hypotheses are given to next()) or
/// after (loops of ORB-SLAM: only confirmed ones are worth verifying).
class Acceptance {
 public:
  explicit Acceptance(const AcceptanceOptions& options) : options_(options) {}

  /// The hypotheses of the next frame or keyframe, possibly none. A hypothesis that continues one of the previous frame
  /// gets its confirmations plus one. Rejected ones are returned unchanged and confirm nothing.
  std::vector<Hypothesis> next(std::vector<Hypothesis> hypotheses);
  /// The hypothesis after verification.
  Hypothesis judged(Hypothesis hypothesis, const Evidence& evidence) const;
  /// Hypotheses that the last next() dropped, as rejected: too many frames did not recognize them.
  const std::vector<Hypothesis>& given_up() const { return given_up_; }
  /// Forgets all previous frames: after a loop closure the groups are no longer valid.
  void clear();

 private:
  struct Tracked {
    Hypothesis hypothesis;
    int missed = 0;
  };

  AcceptanceOptions options_;
  std::vector<Tracked> before_;
  std::vector<Hypothesis> given_up_;
};

/// How accepting a hypothesis would correct the map.
struct MapCorrection {
  std::int64_t observer = 0;                                    ///< Frame, keyframe or scan that recognized the place.
  SE3 corrected_from_world;                                     ///< The correction of poses around the observer.
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();  ///< Of the observer, before the correction.
};

struct AgreementLimits {
  double max_distance_m = 0.0, max_angle_rad = 0.0;  ///< Both exclusive.
};

/// Pairwise consistency (Olson 2009, "Recognizing places using spectrally clustered local matches", only its pairwise
/// test): one place may look like another, but two observers whose hypotheses would correct the map alike are hardly
/// both wrong. One entry per hypothesis: 1 if another observer agrees with it, or if it moves the map by less than the
/// limits.
std::vector<std::uint8_t> agreeing(std::span<const MapCorrection> corrections, const AgreementLimits& limits);

/// Distance between two values of a relative pose in standard deviations, as a gate before the graph is changed (Latif
/// et al. 2013, "Robust loop closing over time for pose graph SLAM", judge loops by the same distance). `covariance` is
/// of d in measured = predicted * exp(d), (translation, rotation), that of both together. Infinite if it is not
/// positive definite or the poses are not finite.
double graph_sigmas(const SE3& predicted, const SE3& measured, const Matrix6d& covariance);

/// How odometry drifts along its path.
struct OdometryDrift {
  double share = 0.0;      ///< Standard deviation of each coordinate, meters per meter of path.
  double rad_per_m = 0.0;  ///< Of each rotation.
  /// For graph_sigmas(), after that path length.
  Matrix6d covariance(double path_m) const;
};

}  // namespace rastro
