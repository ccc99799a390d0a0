// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/visual_words.h"

#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

bool are_real(const Features& features) { return features.length > 0; }

/// Of the first features.
std::vector<RealDescriptor> real_descriptors(const Features& features, std::size_t count) {
  std::vector<RealDescriptor> descriptors(count, RealDescriptor{});
  const auto length = static_cast<std::size_t>(features.length);
  for (std::size_t i = 0; i < count; ++i) {
    const auto values = std::span(features.floats).subspan(i * length, std::min(length, descriptors[i].size()));
    float squares = 0.0F;
    for (const float value : values) squares += value * value;
    const float scale = squares > 0.0F ? 1.0F / std::sqrt(squares) : 0.0F;
    std::transform(values.begin(), values.end(), descriptors[i].begin(), [&](float value) { return scale * value; });
  }
  return descriptors;
}

}  // namespace

std::vector<std::int64_t> VisualWords::add(const Features& features, std::size_t count, TaskPool* pool) {
  is_real_ = are_real(features);
  count = std::min(count, features.size());
  if (is_real_) return real_.add(real_descriptors(features, count), pool);
  return binary_.add(std::span(features.descriptors).first(count), pool);
}

void VisualWords::release(std::span<const std::int64_t> words) {
  is_real_ ? real_.release(words) : binary_.release(words);
}

void VisualWords::restore(std::span<const std::int64_t> words, const Features& features) {
  is_real_ = are_real(features);
  if (is_real_)
    real_.restore(words, real_descriptors(features, words.size()));
  else
    binary_.restore(words, std::span(features.descriptors).first(words.size()));
}

}  // namespace rastro
