// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace rastro {

struct Primitive;

/// Bounding boxes of solids in a binary tree, so that a single ray tests few of them.
class BoundsTree {
 public:
  BoundsTree() = default;
  explicit BoundsTree(std::span<const Primitive> primitives);
  bool empty() const { return nodes_.empty(); }

  /// Calls test(primitive number) for each solid whose box the ray enters before the limit; it returns the new limit.
  template <typename Test>
  void visit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double limit, Test&& test) const {
    if (nodes_.empty()) return;
    const Eigen::Vector3d inverse =
        direction.unaryExpr([](double slope) { return 1.0 / (slope == 0.0 ? 1e-300 : slope); });
    std::uint32_t stack[64];
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const Node& node = nodes_[stack[--depth]];
      if (!entered(node, origin, inverse, limit)) continue;
      for (std::uint32_t i = node.begin; i < node.end; ++i) limit = test(order_[i]);
      if (node.begin == node.end) {
        stack[depth++] = node.second;
        stack[depth++] = node.first;
      }
    }
  }

 private:
  struct Node {
    Eigen::Vector3d low, high;
    std::uint32_t first = 0, second = 0;  ///< Children of an inner node.
    std::uint32_t begin = 0, end = 0;     ///< Solids of a leaf, in order_.
  };

  static bool entered(const Node& node, const Eigen::Vector3d& origin, const Eigen::Vector3d& inverse, double limit) {
    double enter = 0.0, leave = limit;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (node.low[axis] - origin[axis]) * inverse[axis],
                   b = (node.high[axis] - origin[axis]) * inverse[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
  }
  std::uint32_t build(std::uint32_t begin, std::uint32_t end, const std::vector<Node>& boxes);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

}  // namespace rastro
