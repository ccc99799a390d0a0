// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/descriptor_matching.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/feature/hamming.h"

namespace rastro {
namespace {

constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();
constexpr float far_off = std::numeric_limits<float>::infinity();

struct Nearest {
  std::uint32_t index = nobody;
  float distance = far_off;
  float runner_up = far_off;

  void offer(std::uint32_t candidate, float value) {
    if (value < distance) {
      runner_up = distance;
      distance = value;
      index = candidate;
    } else if (value < runner_up) {
      runner_up = value;
    }
  }
};

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Map<const RowMajor> matrix_of(const DescribedKeypoints& features) {
  return {features.floats.data(), static_cast<Eigen::Index>(features.size()), features.length};
}

/// Squared Euclidean distances of a block of rows to all of the second image.
class FloatDistances {
 public:
  FloatDistances(const DescribedKeypoints& first, const DescribedKeypoints& second)
      : first_(matrix_of(first)),
        second_(matrix_of(second)),
        first_squares_(first_.rowwise().squaredNorm()),
        second_squares_(second_.rowwise().squaredNorm()) {}

  template <typename Sink>
  void for_rows(int begin, int end, Sink&& sink) const {
    RowMajor products = first_.middleRows(begin, end - begin) * second_.transpose();
    products *= -2.0F;
    products.rowwise() += second_squares_.transpose();
    for (int i = begin; i < end; ++i) {
      auto row = products.row(i - begin);
      row = (row.array() + first_squares_(i)).max(0.0F);
      sink(static_cast<std::uint32_t>(i), row.data());
    }
  }
  static float distance(float value) { return std::sqrt(value); }

 private:
  Eigen::Map<const RowMajor> first_, second_;
  Eigen::VectorXf first_squares_, second_squares_;
};

/// Differing bits, as floats.
class BitDistances {
 public:
  BitDistances(const DescribedKeypoints& first, const DescribedKeypoints& second)
      : first_(first.bits), second_(second.bits) {}

  template <typename Sink>
  void for_rows(int begin, int end, Sink&& sink) const {
    std::vector<std::uint16_t> bits(second_.size());
    std::vector<float> row(second_.size());
    for (int i = begin; i < end; ++i) {
      hamming_distances(first_[static_cast<std::size_t>(i)], second_, bits);
      std::copy(bits.begin(), bits.end(), row.begin());
      sink(static_cast<std::uint32_t>(i), row.data());
    }
  }
  static float distance(float value) { return value; }

 private:
  std::span<const Descriptor> first_, second_;
};

/// The nearest of `second` to each of `first`, and where asked the other way round.
struct Search {
  std::vector<Nearest> of_first, of_second;
};

template <typename Distances>
Search search(const Distances& distances, std::size_t first_size, std::size_t second_size, bool both_ways,
              TaskPool* pool) {
  constexpr int grain = 64;
  Search result{std::vector<Nearest>(first_size), std::vector<Nearest>(both_ways ? second_size : 0)};
  const int rows = static_cast<int>(first_size);
  std::vector<std::vector<Nearest>> offers(static_cast<std::size_t>((rows + grain - 1) / grain));
  const auto body = [&](int begin, int end) {
    auto& offered = offers[static_cast<std::size_t>(begin / grain)];
    offered.resize(result.of_second.size());
    distances.for_rows(begin, end, [&](std::uint32_t i, const float* row) {
      Nearest& mine = result.of_first[i];
      for (std::uint32_t k = 0; k < second_size; ++k) mine.offer(k, row[k]);
      for (std::uint32_t k = 0; k < offered.size(); ++k) offered[k].offer(i, row[k]);
    });
  };
  if (pool != nullptr) {
    pool->for_chunks(0, rows, grain, body);
  } else {
    for (int begin = 0; begin < rows; begin += grain) body(begin, std::min(begin + grain, rows));
  }
  // In the order of the chunks, so that of equal distances the smaller index wins.
  for (const auto& chunk : offers) {
    for (std::size_t k = 0; k < chunk.size(); ++k) result.of_second[k].offer(chunk[k].index, chunk[k].distance);
  }
  return result;
}

template <typename Distances>
std::vector<DescriptorMatch> matches(const DescribedKeypoints& first, const DescribedKeypoints& second,
                                     const DescriptorMatchOptions& options, TaskPool* pool) {
  const Search found = search(Distances(first, second), first.size(), second.size(), options.mutual, pool);
  std::vector<DescriptorMatch> result;
  for (std::uint32_t i = 0; i < first.size(); ++i) {
    const Nearest& nearest = found.of_first[i];
    if (nearest.index == nobody) continue;
    if (options.mutual && found.of_second[nearest.index].index != i) continue;
    const auto distance = static_cast<double>(Distances::distance(nearest.distance));
    if (!(distance <= options.max_distance)) continue;
    const auto runner_up = static_cast<double>(Distances::distance(nearest.runner_up));
    if (options.max_ratio < 1.0 && !(distance < options.max_ratio * runner_up)) continue;
    result.push_back({i, nearest.index, static_cast<float>(distance)});
  }
  return result;
}

}  // namespace

std::vector<DescriptorMatch> match_descriptors(const DescribedKeypoints& first, const DescribedKeypoints& second,
                                               const DescriptorMatchOptions& options, TaskPool* pool) {
  if (first.size() == 0 || second.size() == 0) return {};
  if (first.length != second.length) {
    throw Error("descriptors of two kinds cannot be compared", "matching",
                "describe both images by the same extractor");
  }
  return first.binary() ? matches<BitDistances>(first, second, options, pool)
                        : matches<FloatDistances>(first, second, options, pool);
}

}  // namespace rastro
