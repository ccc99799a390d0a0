// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "rastro/export/word_kinds.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/map/signatures/signature_layer.h"

namespace rastro::cli {
namespace {

/// A keyframe and the earlier one of its newest loop closure.
struct Pair {
  KeyframeId own = no_keyframe, matched = no_keyframe;
};

bool closes_loop(const Constraint& constraint) {
  return constraint.kind == ConstraintKind::loop || constraint.kind == ConstraintKind::merge ||
         constraint.kind == ConstraintKind::inter_robot;
}

/// The newest closure of those from row `first` on; of a joint one the keyframes that came in last.
Pair newest_closure(const Map& map, std::size_t first) {
  for (std::size_t row = map.constraints.size(); row-- > first;) {
    const Constraint& constraint = map.constraints[row];
    if (closes_loop(constraint))
      return {std::max(constraint.from, constraint.to), std::min(constraint.from, constraint.to)};
  }
  return {};
}

/// That of the map, else the one that a page was sent.
std::optional<LiveImage> image_of(const Map& map, KeyframeId id, const SeenImages& seen) {
  const Keyframe* keyframe = map.find(id);
  if (keyframe == nullptr) return std::nullopt;
  const auto layer = map.layer<ImageLayer>();
  const auto camera = static_cast<std::size_t>(keyframe->camera);
  const bool has_size = camera < map.cameras.size() && map.cameras[camera].intrinsics.width > 0;
  if (!layer || !has_size || !std::binary_search(layer->keyframes.begin(), layer->keyframes.end(), id))
    return seen.near(keyframe->stamp);
  LiveImage image;
  image.index = keyframe->frame;
  image.width = map.cameras[camera].intrinsics.width;
  image.height = map.cameras[camera].intrinsics.height;
  image.jpeg = layer->store->read(id).color;
  return image.jpeg.empty() ? seen.near(keyframe->stamp) : std::optional(std::move(image));
}

LiveFeatures words_of(const Signature& signature, const std::vector<std::optional<WordKind>>& kinds) {
  LiveFeatures features;
  features.state_names = {"known_word", "new_word", "repeated_word", "previous_word", "shared_word"};
  for (std::size_t row = 0; row < kinds.size(); ++row) {
    if (!kinds[row]) continue;
    const Keypoint& point = signature.image->features.keypoints[row];
    features.pixels.insert(features.pixels.end(), {point.x, point.y});
    features.states.push_back(static_cast<std::uint8_t>(index_of(*kinds[row])));
  }
  return features;
}

/// Blue (far) over green to red (near), as Engel et al. 2014 color them.
std::array<std::uint8_t, 3> color_of_depth(float share) {
  const auto channel = [share](float middle) {
    return static_cast<std::uint8_t>(
        std::lround(255.0F * std::clamp(1.5F - std::abs(4.0F * share - middle), 0.0F, 1.0F)));
  };
  return {channel(3.0F), channel(2.0F), channel(1.0F)};
}

/// Some of the pixels, evenly. The scale ends at the nearest twentieth of them.
LiveFeatures depths_of(const SemiDenseDepth& depth) {
  constexpr std::size_t most = 6000;
  LiveFeatures features;
  features.state_names = {"depth"};
  std::vector<float> inverse_depths;
  for (const SemiDenseDepth::Pixel& pixel : depth.pixels) inverse_depths.push_back(pixel.inverse_depth);
  if (inverse_depths.empty()) return features;
  const auto limit = inverse_depths.begin() + static_cast<std::ptrdiff_t>(inverse_depths.size() * 19 / 20);
  std::nth_element(inverse_depths.begin(), limit, inverse_depths.end());
  const float largest = std::max(*limit, 1e-9F);
  for (std::size_t row = 0; row < depth.pixels.size(); row += 1 + depth.pixels.size() / most) {
    const SemiDenseDepth::Pixel& pixel = depth.pixels[row];
    const auto color = color_of_depth(std::clamp(pixel.inverse_depth / largest, 0.0F, 1.0F));
    features.pixels.insert(features.pixels.end(), {static_cast<float>(pixel.x), static_cast<float>(pixel.y)});
    features.states.push_back(0);
    features.colors.insert(features.colors.end(), color.begin(), color.end());
  }
  return features;
}

/// Of the locations after `shown` the newest one that closed a loop, else the newest one.
const LocationWords* newest_location(const std::vector<LocationWords>& all, KeyframeId shown) {
  for (std::size_t row = all.size(); row-- > 0 && all[row].location > shown;)
    if (all[row].closure) return &all[row];
  return all.empty() ? nullptr : &all.back();
}

/// nullopt where an image is missing.
std::optional<LivePlace> place_with_images(const Map& map, const Pair& pair, const SeenImages& seen) {
  auto image = image_of(map, pair.own, seen);
  if (!image) return std::nullopt;
  LivePlace place{std::move(*image), pair.own, std::nullopt, pair.matched};
  if (pair.matched != no_keyframe) place.matched_image = image_of(map, pair.matched, seen);
  return place;
}

std::optional<LivePlace> place_with_words(const Map& map, const SignatureStore& store, const LocationWords& location,
                                          const SeenImages& seen) {
  auto place = place_with_images(map, {location.location, location.matched}, seen);
  if (!place) return std::nullopt;
  const Signature own = store.read(location.location);
  place->image.features = words_of(own, location.kinds);
  if (!place->matched_image) return place;
  const Signature matched = store.read(location.matched);
  place->matched_image->features = words_of(matched, kinds_seen_from(own.words, matched.words));
  return place;
}

void add_depths(const SemiDenseLayer& depths, LivePlace& place) {
  const auto add = [&](KeyframeId id, LiveImage& image) {
    const auto depth = depths.of.find(id);
    if (depth != depths.of.end()) image.features = depths_of(*depth->second);
  };
  add(place.keyframe, place.image);
  if (place.matched_image) add(place.matched, *place.matched_image);
}

}  // namespace

void LivePlaces::note(const SlamUpdate& update) {
  for (const SlamEvent& event : update.events) {
    if (event.place == no_keyframe) continue;
    const std::lock_guard lock(mutex_);
    relocalization_ = {update.index, update.stamp, event.place};
  }
}

std::optional<LivePlace> LivePlaces::relocalized(const Map& map, const SeenImages& seen) {
  std::optional<Relocalization> found;
  {
    const std::lock_guard lock(mutex_);
    found = std::exchange(relocalization_, std::nullopt);
  }
  if (!found) return std::nullopt;
  auto image = seen.near(found->stamp);
  auto matched = image_of(map, found->place, seen);
  if (!image || !matched) return std::nullopt;
  return LivePlace{std::move(*image), no_keyframe, std::move(matched), found->place};
}

std::optional<LivePlace> LivePlaces::of(const Map& map, const SeenImages& seen) {
  if (forgets_.exchange(false)) {
    seen_constraints_ = 0;
    shown_ = no_keyframe;
  }
  const std::size_t first = std::min(std::exchange(seen_constraints_, map.constraints.size()), map.constraints.size());
  if (auto place = relocalized(map, seen)) return place;
  if (const auto signatures = map.layer<SignatureLayer>()) {
    const auto all = words_of_locations(map);
    const LocationWords* location = newest_location(all, shown_);
    if (location == nullptr || location->location == std::exchange(shown_, location->location)) return std::nullopt;
    return place_with_words(map, *signatures->store, *location, seen);
  }
  Pair pair = newest_closure(map, first);
  const auto depths = map.layer<SemiDenseLayer>();
  if (pair.own == no_keyframe && depths && !map.keyframes.empty()) pair.own = map.keyframes.back().id;
  if (pair.own == no_keyframe || pair.own == std::exchange(shown_, pair.own)) return std::nullopt;
  auto place = place_with_images(map, pair, seen);
  if (place && depths) add_depths(*depths, *place);
  return place;
}

}  // namespace rastro::cli
