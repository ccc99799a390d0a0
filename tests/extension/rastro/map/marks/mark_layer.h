// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "rastro/map/keyframe_layer.h"

namespace rastro {

/// Something that a person has named in an image.
struct Mark {
  std::string word;             ///< Without blanks.
  Eigen::Vector3d in_keyframe;  ///< Where it is, meters.
  bool operator==(const Mark&) const = default;
};
using Marks = std::vector<Mark>;

/// The marks of each keyframe.
struct MarkLayer : KeyframeLayer<Marks> {
  static constexpr const char* layer_name = "marks";
};

std::unique_ptr<LayerType> marks_layer_type();

}  // namespace rastro
