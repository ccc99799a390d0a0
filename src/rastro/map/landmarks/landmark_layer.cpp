// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmarks/landmark_layer.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/map/features/feature_layer.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/landmark_bytes.h"
#include "rastro/map/file/row_parts.h"
#include "rastro/map/landmarks/landmark_uncertainty.h"

namespace rastro {
namespace {

const LandmarkLayer& typed(const Layer& layer) { return static_cast<const LandmarkLayer&>(layer); }

std::size_t index_in(const LandmarkLayer& layer, std::int64_t id) {
  const auto at = std::lower_bound(layer.landmarks.begin(), layer.landmarks.end(), id,
                                   [](const Landmark& landmark, std::int64_t wanted) { return landmark.id < wanted; });
  return static_cast<std::size_t>(at - layer.landmarks.begin());
}

bool same(const Landmark& a, const Landmark& b) {
  return a.position == b.position && a.direction == b.direction && a.descriptor == b.descriptor &&
         a.min_distance == b.min_distance && a.max_distance == b.max_distance && a.observations == b.observations;
}

bool same(const LandmarkEstimate& a, const LandmarkEstimate& b) {
  return a.sensor_id == b.sensor_id && a.observations == b.observations && a.covariance == b.covariance;
}

void put_estimate(ByteWriter& bytes, const LandmarkEstimate& estimate) {
  bytes.put(estimate.sensor_id);
  bytes.put<std::int32_t>(estimate.observations);
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) bytes.put(estimate.covariance(i, j));
}

LandmarkEstimate get_estimate(ByteReader& bytes) {
  LandmarkEstimate estimate;
  estimate.sensor_id = bytes.get<std::int64_t>();
  estimate.observations = bytes.get<std::int32_t>();
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) estimate.covariance(i, j) = estimate.covariance(j, i) = bytes.get<double>();
  return estimate;
}

/// Whether an observation refers to an existing feature; unknown for a map without features.
bool leads_somewhere(const Map& map, const FeatureLayer* features, const LandmarkObservation& observation) {
  if (!map.index_of(observation.keyframe)) return false;
  if (!features) return true;
  const ImageFeatures* image = features->find(observation.keyframe);
  return image && observation.feature < image->features.size();
}

std::string contradiction_of(const Map& map, const FeatureLayer* features, const Landmark& landmark) {
  if (!landmark.position.allFinite() || !landmark.direction.allFinite()) return "has a landmark without a position";
  KeyframeId last = no_keyframe;
  for (const LandmarkObservation& observation : landmark.observations) {
    if (observation.keyframe <= last) return "has a landmark whose observations are out of order";
    last = observation.keyframe;
    if (!leads_somewhere(map, features, observation))
      return "has a landmark observed by a keyframe or feature that is not there";
  }
  return {};
}

class LandmarkLayerType : public LayerType {
 public:
  std::string name() const override { return LandmarkLayer::layer_name; }

  std::vector<std::int64_t> rows(const Layer& layer) const override {
    std::vector<std::int64_t> ids;
    for (const Landmark& landmark : typed(layer).landmarks) ids.push_back(landmark.id);
    return ids;
  }

  std::string row(const Layer& layer, std::int64_t id) const override {
    const std::size_t index = index_in(typed(layer), id);
    const Landmark& landmark = typed(layer).landmarks[index];
    ByteWriter bytes;
    put(bytes, landmark.position);
    put(bytes, landmark.direction);
    bytes.put_raw(landmark.descriptor.words.data(), sizeof landmark.descriptor.words);
    bytes.put(landmark.min_distance);
    bytes.put(landmark.max_distance);
    bytes.put(static_cast<std::uint32_t>(landmark.observations.size()));
    for (const LandmarkObservation& observation : landmark.observations) {
      bytes.put(observation.keyframe);
      bytes.put(observation.feature);
    }
    const bool estimated = !typed(layer).estimates.empty();
    bytes.put(static_cast<std::uint8_t>(estimated));
    if (estimated) put_estimate(bytes, typed(layer).estimates[index]);
    return bytes.take();
  }

  bool same_row(const Layer& before, const Layer& now, std::int64_t id) const override {
    const LandmarkLayer &a = typed(before), &b = typed(now);
    const std::size_t i = index_in(a, id), j = index_in(b, id);
    return same(a.landmarks[i], b.landmarks[j]) && a.estimates.empty() == b.estimates.empty() &&
           (a.estimates.empty() || same(a.estimates[i], b.estimates[j]));
  }

  std::shared_ptr<Layer> make(std::string_view, const std::string&) const override {
    return std::make_shared<LandmarkLayer>();
  }

  void read(Layer& layer, std::int64_t id, std::string_view body, const std::string& where) const override {
    ByteReader bytes(body, where);
    auto& into = static_cast<LandmarkLayer&>(layer);
    Landmark landmark = get_landmark(bytes, id);
    const auto estimated = bytes.get<std::uint8_t>();
    bytes.check(estimated <= 1 && into.estimates.size() == (estimated == 1 ? into.landmarks.size() : 0));
    std::optional<LandmarkEstimate> estimate;
    if (estimated == 1) estimate = get_estimate(bytes);
    bytes.finish();
    into.landmarks.push_back(std::move(landmark));
    if (estimate) into.estimates.push_back(*estimate);
  }

  std::string contradiction(const Map& map, const Layer& layer) const override {
    const auto features = map.layer<FeatureLayer>();
    const std::vector<Landmark>& landmarks = typed(layer).landmarks;
    if (!typed(layer).estimates.empty() && typed(layer).estimates.size() != landmarks.size())
      return "has landmarks without an estimate";
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      if (landmarks[i].id < 0 || (i > 0 && landmarks[i].id <= landmarks[i - 1].id)) return "has landmarks out of order";
      if (std::string fault = contradiction_of(map, features.get(), landmarks[i]); !fault.empty()) return fault;
    }
    return {};
  }

  std::shared_ptr<const Layer> repaired(const Map& map, const std::shared_ptr<const Layer>& layer) const override {
    const auto features = map.layer<FeatureLayer>();
    const LandmarkLayer& all = typed(*layer);
    auto kept = std::make_shared<LandmarkLayer>();
    for (std::size_t i = 0; i < all.landmarks.size(); ++i) {
      Landmark landmark = all.landmarks[i];
      if (!landmark.position.allFinite() || !landmark.direction.allFinite()) continue;
      std::erase_if(landmark.observations,
                    [&](const auto& each) { return !leads_somewhere(map, features.get(), each); });
      if (landmark.observations.empty() && all.estimates.empty()) continue;
      kept->landmarks.push_back(std::move(landmark));
      if (!all.estimates.empty()) kept->estimates.push_back(all.estimates[i]);
    }
    return kept;
  }

  LayerDescription describe(const Map&, const Layer& layer) const override {
    const auto count = static_cast<double>(typed(layer).landmarks.size());
    double observations = 0.0;
    for (const Landmark& each : typed(layer).landmarks) observations += static_cast<double>(each.observations.size());
    for (const LandmarkEstimate& each : typed(layer).estimates) observations += each.observations;
    const double each = count > 0.0 ? observations / count : 0.0;
    return {fmt::format("{} landmarks, observed {:.1f} times each", typed(layer).landmarks.size(), each),
            {{"landmarks", count}, {"observations_per_landmark", each}}};
  }

  void add_points(const Map& map, const Layer& layer, int submap, std::size_t /*most*/,
                  PointCloud& cloud) const override {
    constexpr std::uint8_t unknown_color = 160;
    for (const Landmark& landmark : typed(layer).landmarks) {
      if (submap >= 0 && submap_of(map, landmark) != submap) continue;
      CloudPoint point;
      point.position = landmark.position.cast<float>();
      point.normal = -landmark.direction.cast<float>();
      point.color = {unknown_color, unknown_color, unknown_color};
      point.count = static_cast<std::uint32_t>(landmark.observations.size());
      const auto covariance = landmark_covariance(map, landmark);
      const double variance = covariance ? landmark.direction.dot(*covariance * landmark.direction) : 0.0;
      point.sigma = variance > 0.0 ? static_cast<float>(std::sqrt(variance)) : 0.0F;
      cloud.points.push_back(point);
    }
  }

  /// Landmarks stay, without the observations of the keyframe.
  LayerCut cut(const Layer& layer, KeyframeId id) const override {
    auto rest = std::make_shared<LandmarkLayer>(typed(layer));
    ByteWriter bytes;
    bool any = false;
    for (Landmark& landmark : rest->landmarks) {
      const auto found = std::find_if(landmark.observations.begin(), landmark.observations.end(),
                                      [id](const LandmarkObservation& each) { return each.keyframe == id; });
      if (found == landmark.observations.end()) continue;
      bytes.put(landmark.id);
      bytes.put(found->feature);
      landmark.observations.erase(found);
      any = true;
    }
    return {std::move(rest), any ? bytes.take() : std::string()};
  }

  std::shared_ptr<const Layer> paste(const Layer& layer, KeyframeId id, std::string_view body) const override {
    auto whole = std::make_shared<LandmarkLayer>(typed(layer));
    const std::string where = name();
    ByteReader bytes(body, where);
    while (bytes.left() > 0) {
      const auto landmark_id = bytes.get<std::int64_t>();
      const auto feature = bytes.get<std::uint32_t>();
      const std::size_t index = index_in(*whole, landmark_id);
      if (index >= whole->landmarks.size() || whole->landmarks[index].id != landmark_id) continue;
      auto& observations = whole->landmarks[index].observations;
      const auto at =
          std::lower_bound(observations.begin(), observations.end(), id,
                           [](const LandmarkObservation& each, KeyframeId wanted) { return each.keyframe < wanted; });
      if (at == observations.end() || at->keyframe != id) observations.insert(at, {id, feature});
    }
    return whole;
  }

  std::shared_ptr<const Layer> renumbered(const std::shared_ptr<const Layer>& layer,
                                          const std::map<KeyframeId, KeyframeId>& new_id) const override {
    auto result = std::make_shared<LandmarkLayer>(typed(*layer));
    for (Landmark& landmark : result->landmarks)
      for (LandmarkObservation& observation : landmark.observations)
        observation.keyframe = new_id.at(observation.keyframe);
    return result;
  }
};

}  // namespace

Landmark get_landmark(ByteReader& bytes, std::int64_t id) {
  Landmark landmark;
  landmark.id = id;
  landmark.position = get_vector(bytes);
  landmark.direction = get_vector(bytes);
  for (std::uint64_t& word : landmark.descriptor.words) word = bytes.get<std::uint64_t>();
  landmark.min_distance = bytes.get<float>();
  landmark.max_distance = bytes.get<float>();
  landmark.observations.resize(bytes.count(sizeof(std::int64_t) + sizeof(std::uint32_t)));
  KeyframeId last = no_keyframe;
  for (LandmarkObservation& observation : landmark.observations) {
    observation.keyframe = bytes.get<std::int64_t>();
    observation.feature = bytes.get<std::uint32_t>();
    bytes.check(observation.keyframe > last);
    last = observation.keyframe;
  }
  return landmark;
}

const Landmark* LandmarkLayer::find(std::int64_t id) const {
  const std::size_t index = index_in(*this, id);
  return index < landmarks.size() && landmarks[index].id == id ? &landmarks[index] : nullptr;
}

int submap_of(const Map& map, const Landmark& landmark) {
  if (landmark.observations.empty()) return 0;
  const Keyframe* keyframe = map.find(landmark.observations.front().keyframe);
  return keyframe ? keyframe->submap : 0;
}

std::unique_ptr<LayerType> landmarks_layer_type() { return std::make_unique<LandmarkLayerType>(); }

}  // namespace rastro
