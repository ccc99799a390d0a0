// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/marks/mark_layer.h"

#include <fmt/format.h>

#include <cstdlib>
#include <sstream>

#include "rastro/base/error.h"

namespace rastro {
namespace {

class MarkLayerType : public KeyframeLayerType<MarkLayer, Marks> {
 public:
  /// One line a mark.
  std::string body_of(const Marks& marks) const override {
    std::string body;
    for (const auto& [word, position] : marks)
      body += fmt::format("{:a} {:a} {:a} {}\n", position.x(), position.y(), position.z(), word);
    return body;
  }
  std::shared_ptr<const Marks> thing_of(KeyframeId, std::string_view body, const std::string& where) const override {
    auto marks = std::make_shared<Marks>();
    std::istringstream lines{std::string(body)};
    for (std::string line; std::getline(lines, line);) {
      std::istringstream parts(line);
      std::string x, y, z, word;
      if (!(parts >> x >> y >> z >> word)) throw Error("has marks that cannot be read", where, "mark again");
      marks->push_back({word, {number(x, where), number(y, where), number(z, where)}});
    }
    return marks;
  }

  LayerDescription describe(const Map&, const Layer& layer) const override {
    std::size_t count = 0;
    for (const auto& [id, marks] : typed(layer).of) count += marks->size();
    return {fmt::format("{} marks in {} keyframes", count, typed(layer).of.size()),
            {{"marks", static_cast<double>(count)}}};
  }

  void add_points(const Map& map, const Layer& layer, int submap, std::size_t /*most*/,
                  PointCloud& cloud) const override {
    for (const auto& [id, marks] : typed(layer).of) {
      const Keyframe* keyframe = map.find(id);
      if (!keyframe || (submap >= 0 && keyframe->submap != submap)) continue;
      for (const Mark& mark : *marks) {
        CloudPoint& point = cloud.points.emplace_back();
        point.position = (keyframe->world_from_camera * mark.in_keyframe).cast<float>();
        point.count = 1;
      }
    }
  }

 private:
  static double number(const std::string& text, const std::string& where) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0') throw Error("has a mark without a position", where, "mark again");
    return value;
  }
};

}  // namespace

std::unique_ptr<LayerType> marks_layer_type() { return std::make_unique<MarkLayerType>(); }

}  // namespace rastro
