// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <memory>
#include <vector>

#include "rastro/feature/features.h"
#include "rastro/feature/orb.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/file/bytes.h"

namespace rastro {

void put(ByteWriter& bytes, const Features& features);
Features get_features(ByteReader& bytes);
void put(ByteWriter& bytes, const OrbOptions& options);
OrbOptions get_orb_options(ByteReader& bytes);
void put(ByteWriter& bytes, const std::vector<float>& values);
std::vector<float> get_floats(ByteReader& bytes);

/// Without its id.
void put(ByteWriter& bytes, const ImageFeatures& image);
std::shared_ptr<ImageFeatures> get_image_features(ByteReader& bytes);

std::vector<Keypoint> get_keypoints(ByteReader& bytes, std::size_t count);
std::vector<Descriptor> get_descriptors(ByteReader& bytes, std::size_t count);

}  // namespace rastro
