// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/bounds_tree.h"

#include <algorithm>
#include <numeric>

#include "rastro/synthetic/scene.h"

namespace rastro {
namespace {

constexpr std::uint32_t leaf_size = 2;

}  // namespace

BoundsTree::BoundsTree(std::span<const Primitive> primitives) {
  std::vector<Node> boxes(primitives.size());
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    // Slightly larger, so that rounding never drops a solid that the exact test would hit.
    const Eigen::Vector3d reach = (primitives[i].world_from_local.cwiseAbs() * primitives[i].half).array() + 1e-6;
    boxes[i].low = primitives[i].center - reach;
    boxes[i].high = primitives[i].center + reach;
  }
  order_.resize(primitives.size());
  std::iota(order_.begin(), order_.end(), 0U);
  if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()), boxes);
}

std::uint32_t BoundsTree::build(std::uint32_t begin, std::uint32_t end, const std::vector<Node>& boxes) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  Node node = boxes[order_[begin]];
  for (std::uint32_t i = begin; i < end; ++i) {
    node.low = node.low.cwiseMin(boxes[order_[i]].low);
    node.high = node.high.cwiseMax(boxes[order_[i]].high);
  }
  nodes_.push_back(node);
  if (end - begin <= leaf_size) {
    nodes_[number].begin = begin;
    nodes_[number].end = end;
    return number;
  }
  int axis = 0;
  (node.high - node.low).maxCoeff(&axis);
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const double middle_a = boxes[a].low[axis] + boxes[a].high[axis],
                 middle_b = boxes[b].low[axis] + boxes[b].high[axis];
    return middle_a != middle_b ? middle_a < middle_b : a < b;
  };
  std::sort(order_.begin() + begin, order_.begin() + end, before);
  const std::uint32_t middle = begin + (end - begin) / 2;
  const std::uint32_t first = build(begin, middle, boxes);
  const std::uint32_t second = build(middle, end, boxes);
  nodes_[number].first = first;
  nodes_[number].second = second;
  return number;
}

}  // namespace rastro
