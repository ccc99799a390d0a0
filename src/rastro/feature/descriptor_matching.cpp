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

/// Distance of no match.
template <typename Value>
constexpr Value far_off() {
  return std::numeric_limits<Value>::has_infinity ? std::numeric_limits<Value>::infinity()
                                                  : std::numeric_limits<Value>::max();
}

template <typename Value>
Value least(const Value* values, std::size_t count) {
  Value result = far_off<Value>();
  for (std::size_t i = 0; i < count; ++i) result = values[i] < result ? values[i] : result;
  return result;
}

struct Nearest {
  std::uint32_t index = nobody;
  float distance = std::numeric_limits<float>::infinity();
  float runner_up = std::numeric_limits<float>::infinity();
};

/// The nearest and the second nearest of a row, which is modified. Three plain passes run faster than one with
/// branches.
template <typename Value>
Nearest nearest_of(Value* row, std::size_t count) {
  const Value nearest = least(row, count);
  if (!(nearest < far_off<Value>())) return {};
  Nearest result;
  result.index = static_cast<std::uint32_t>(std::find(row, row + count, nearest) - row);
  row[result.index] = far_off<Value>();
  const Value runner_up = least(row, count);
  row[result.index] = nearest;
  result.distance = static_cast<float>(nearest);
  if (runner_up < far_off<Value>()) result.runner_up = static_cast<float>(runner_up);
  return result;
}

/// For each of the second image, the nearest of the rows offered so far; of equal ones the first.
template <typename Value, typename Index>
struct NearestRows {
  std::vector<Value> distance;
  std::vector<Index> row;

  explicit NearestRows(std::size_t count = 0) : distance(count, far_off<Value>()), row(count, Index{0}) {}
  void offer(Index candidate, const Value* values) {
    const std::size_t count = distance.size();
    Value* best = distance.data();
    Index* of = row.data();
    for (std::size_t k = 0; k < count; ++k) {
      const bool nearer = values[k] < best[k];
      of[k] = nearer ? candidate : of[k];
      best[k] = nearer ? values[k] : best[k];
    }
  }
};

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Map<const RowMajor> matrix_of(const Features& features) {
  return {features.floats.data(), static_cast<Eigen::Index>(features.size()), features.length};
}

/// Squared Euclidean distances of a block of rows to all of the second image.
class FloatDistances {
 public:
  using Value = float;
  using Index = std::int32_t;

  FloatDistances(const Features& first, const Features& second)
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

/// Differing bits. Signed 16 bits, whose minimum every processor has in SIMD.
class BitDistances {
 public:
  using Value = std::int16_t;
  using Index = std::int16_t;

  BitDistances(const Features& first, const Features& second)
      : first_(first.descriptors), second_(second.descriptors) {}

  template <typename Sink>
  void for_rows(int begin, int end, Sink&& sink) const {
    std::vector<std::uint16_t> bits(second_.size());
    std::vector<Value> row(second_.size());
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

/// The nearest of `second` to each of `first` and, on request, the reverse.
struct Search {
  std::vector<Nearest> of_first;
  std::vector<std::uint32_t> of_second;
};

template <typename Distances>
Search search(const Distances& distances, std::size_t first_size, std::size_t second_size, bool both_ways,
              TaskPool* pool) {
  using Value = typename Distances::Value;
  using Rows = NearestRows<Value, typename Distances::Index>;
  constexpr int grain = 64;
  const std::size_t columns = both_ways ? second_size : 0;
  Search result{std::vector<Nearest>(first_size), std::vector<std::uint32_t>(columns, nobody)};
  const int rows = static_cast<int>(first_size);
  std::vector<Rows> chunks(static_cast<std::size_t>((rows + grain - 1) / grain));
  const auto body = [&](int begin, int end) {
    Rows offered(columns);
    distances.for_rows(begin, end, [&](std::uint32_t i, Value* row) {
      offered.offer(static_cast<typename Distances::Index>(static_cast<int>(i) - begin), row);
      result.of_first[i] = nearest_of(row, second_size);
    });
    chunks[static_cast<std::size_t>(begin / grain)] = std::move(offered);
  };
  if (pool != nullptr) {
    pool->for_chunks(0, rows, grain, body);
  } else {
    for (int begin = 0; begin < rows; begin += grain) body(begin, std::min(begin + grain, rows));
  }
  // In the order of the chunks, so that of equal distances the smaller index wins.
  std::vector<Value> best(columns, far_off<Value>());
  for (std::size_t chunk = 0; chunk < chunks.size(); ++chunk) {
    for (std::size_t k = 0; k < columns; ++k) {
      if (!(chunks[chunk].distance[k] < best[k])) continue;
      best[k] = chunks[chunk].distance[k];
      result.of_second[k] =
          static_cast<std::uint32_t>(chunk * grain) + static_cast<std::uint32_t>(chunks[chunk].row[k]);
    }
  }
  return result;
}

template <typename Distances>
std::vector<DescriptorMatch> matches(const Features& first, const Features& second,
                                     const DescriptorMatchOptions& options, TaskPool* pool) {
  const Search found = search(Distances(first, second), first.size(), second.size(), options.mutual, pool);
  std::vector<DescriptorMatch> result;
  for (std::uint32_t i = 0; i < first.size(); ++i) {
    const Nearest& nearest = found.of_first[i];
    if (nearest.index == nobody) continue;
    if (options.mutual && found.of_second[nearest.index] != i) continue;
    const auto distance = static_cast<double>(Distances::distance(nearest.distance));
    if (!(distance <= options.max_distance)) continue;
    const auto runner_up = static_cast<double>(Distances::distance(nearest.runner_up));
    if (options.max_ratio < 1.0 && !(distance < options.max_ratio * runner_up)) continue;
    result.push_back({i, nearest.index, static_cast<float>(distance)});
  }
  return result;
}

}  // namespace

std::vector<DescriptorMatch> match_descriptors(const Features& first, const Features& second,
                                               const DescriptorMatchOptions& options, TaskPool* pool) {
  if (first.size() == 0 || second.size() == 0) return {};
  if (first.length != second.length) {
    throw Error("descriptors of two kinds cannot be compared", "matching", "use the same extractor for both images");
  }
  return first.binary() ? matches<BitDistances>(first, second, options, pool)
                        : matches<FloatDistances>(first, second, options, pool);
}

}  // namespace rastro
