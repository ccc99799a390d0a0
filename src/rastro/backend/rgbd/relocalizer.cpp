// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/relocalizer.h"

#include <tuple>

#include "rastro/backend/acceptance.h"
#include "rastro/backend/loop_candidates.h"
#include "rastro/base/random.h"

namespace rastro {

Relocalizer::Relocalizer(const RgbdSlamOptions& options, const Camera& camera, DepthStore& depths,
                         AppearanceStore& appearances)
    : options_(options), depths_(depths), appearances_(appearances), features_(options), matcher_(options, camera) {}

std::vector<std::int64_t> Relocalizer::candidates(std::int64_t count, std::uint64_t seed) {
  LoopCandidates candidates(count);
  candidates.add_latest(count, options_.relocalize_last);
  Random random(seed);
  for (int k = 0; k < options_.relocalize_random; ++k) {
    candidates.add(random.below(static_cast<std::uint32_t>(count)));
    candidates.add(next_in_order_++ % count);
  }
  return candidates.ids();
}

Relocalizer::Try Relocalizer::find(const Frame& frame,
                                   const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes,
                                   std::uint64_t seed, const First& first) {
  Try result;
  if (keyframes.empty()) return result;
  const ImageFeatures seen = features_.extract(frame);
  result.features = static_cast<int>(seen.features.size());
  compare(seen, frame, keyframes, first.ids, seed, result);
  if (!result.found && first.similar) {
    std::vector<Choice> choices;
    for (const auto& keyframe : first.similar(seen)) choices.push_back({keyframe->id, keyframe});
    compare(seen, frame, choices, seed, result);
  }
  if (result.found) return result;
  compare(seen, frame, keyframes, candidates(static_cast<std::int64_t>(keyframes.size()), seed), seed, result);
  return result;
}

std::optional<Relocalizer::Found> Relocalizer::find_among(
    const Frame& frame, const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes, std::uint64_t seed) {
  std::vector<Choice> choices;
  for (const auto& keyframe : keyframes) choices.push_back({keyframe->id, keyframe});
  Try result;
  compare(features_.extract(frame), frame, choices, seed, result);
  return result.found;
}

void Relocalizer::compare(const ImageFeatures& seen, const Frame& frame,
                          const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes,
                          const std::vector<std::int64_t>& ids, std::uint64_t seed, Try& result) {
  std::vector<Choice> choices;
  for (const std::int64_t id : ids) choices.push_back({id, keyframes[static_cast<std::size_t>(id)]});
  compare(seen, frame, choices, seed, result);
}

void Relocalizer::compare(const ImageFeatures& seen, const Frame& frame, const std::vector<Choice>& choices,
                          std::uint64_t seed, Try& result) {
  if (choices.empty()) return;
  const auto grid = std::make_shared<const KeyframeSurface>(matcher_.surfaces().surface_of(frame.depth));
  std::optional<KeyframeAppearance> appearance;
  for (const auto& [id, keyframe] : choices) {
    if (keyframe->features.size() == 0) continue;
    ++result.compared;
    const auto depth = [this, id = id] { return depths_.depth(id); };
    MatchRequest request;
    request.min_inliers = options_.relocalize_inliers;
    request.seed = seed_for(seed, static_cast<std::uint64_t>(id));
    request.max_sigma_m = most_revisit_sigma_m;
    const auto constraint = matcher_.match({keyframe.get(), depth}, {&seen, [&] { return grid; }}, request);
    if (!constraint) continue;
    if (!appearance) appearance = appearances_.check().appearance_of(frame);
    const Found found{id, *constraint, looks_alike(*appearance, id, constraint->a_from_b)};
    const auto rank = [](const Found& each) { return std::tuple(each.looks_alike, each.constraint.inliers); };
    if (!result.found || rank(found) > rank(*result.found)) result.found = found;
  }
}

bool Relocalizer::looks_alike(const KeyframeAppearance& frame, std::int64_t keyframe, const SE3& keyframe_from_frame) {
  if (options_.min_alike <= 0.0) return true;
  const AppearanceAgreement agreement =
      appearances_.check().compare(*appearances_.appearance(keyframe), frame, keyframe_from_frame);
  return judge(agreement.evidence(), {.min_alike_share = options_.min_alike}) == Rejection::none;
}

}  // namespace rastro
