// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/feature/hamming.h"
#include "rastro/place/vocabulary.h"

namespace rastro {
namespace {

using Members = std::vector<std::uint32_t>;  ///< Indices of descriptors.

constexpr int chunk = 4096;                // Descriptors of one task.
constexpr std::size_t large = 32 * chunk;  // Larger clusters are divided with the pool, smaller ones in parallel.

void check(const VocabularyOptions& options, bool has_descriptors) {
  const auto refuse = [](const char* name, int value, const char* range) {
    throw Error(fmt::format("{} {} is out of range", name, value), "the vocabulary", fmt::format("use {}", range));
  };
  if (options.branching < 2 || options.branching > 64) refuse("branching", options.branching, "2..64");
  if (options.depth < 1 || options.depth > 8) refuse("depth", options.depth, "1..8");
  if (options.rounds < 1 || options.rounds > 1000) refuse("rounds", options.rounds, "1..1000");
  if (!has_descriptors) throw Error("there are no descriptors to train from", "the images", "use images with texture");
}

void for_chunks(TaskPool* pool, std::size_t count, int grain, const std::function<void(int, int)>& body) {
  if (pool) {
    pool->for_chunks(0, static_cast<int>(count), grain, body);
  } else if (count > 0) {
    body(0, static_cast<int>(count));
  }
}

/// Centers of clusters of bits: k-means by Hamming distance, where a mean is each bit's majority (k-majority, Grana et
/// al. 2013).
class Division {
 public:
  Division(const std::vector<Descriptor>& all, const Members& members, const VocabularyOptions& options,
           std::uint64_t seed, TaskPool* pool)
      : all_(all), members_(members), pool_(pool), nearest_(members.size()) {
    choose_centers(options.branching, Random(seed));
    for (int round = 0; round < options.rounds; ++round)
      if (!assign() || !move_centers()) break;
    assign();
  }

  /// The centers that have members, with their members.
  std::vector<std::pair<Descriptor, Members>> clusters() const {
    std::vector<Members> of(centers_.size());
    for (std::size_t i = 0; i < members_.size(); ++i) of[nearest_[i]].push_back(members_[i]);
    std::vector<std::pair<Descriptor, Members>> filled;
    for (std::size_t c = 0; c < centers_.size(); ++c)
      if (!of[c].empty()) filled.emplace_back(centers_[c], std::move(of[c]));
    return filled;
  }

 private:
  const Descriptor& member(std::size_t i) const { return all_[members_[i]]; }

  /// k-means++ (Arthur and Vassilvitskii 2007): each is drawn by its squared distance to those before.
  void choose_centers(int wanted, Random random) {
    std::vector<double> squared(members_.size(), std::numeric_limits<double>::infinity());
    centers_.push_back(member(random.below(static_cast<std::uint32_t>(members_.size()))));
    while (static_cast<int>(centers_.size()) < wanted) {
      for_chunks(pool_, members_.size(), chunk, [&](int begin, int end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          std::uint16_t distance = 0;
          hamming_distances(member(i), {&centers_.back(), 1}, {&distance, 1});
          squared[i] = std::min(squared[i], static_cast<double>(distance) * distance);
        }
      });
      double sum = 0.0;
      for (const double value : squared) sum += value;
      if (sum == 0.0) return;  // All members are centers already.
      double left = random.uniform() * sum;
      std::size_t drawn = 0;
      while (drawn + 1 < squared.size() && (left -= squared[drawn]) >= 0.0) ++drawn;
      while (squared[drawn] == 0.0) --drawn;  // Rounding may have passed the last one.
      centers_.push_back(member(drawn));
    }
  }

  /// Returns whether any member changed its center.
  bool assign() {
    std::vector<std::uint8_t> changed(members_.size() / chunk + 1, 0);
    for_chunks(pool_, members_.size(), chunk, [&](int begin, int end) {
      std::array<std::uint16_t, 64> distances{};
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
        hamming_distances(member(i), centers_, distances);
        const auto best = std::min_element(distances.begin(), distances.begin() + static_cast<long>(centers_.size()));
        const auto now = static_cast<std::uint8_t>(best - distances.begin());
        if (now != nearest_[i] || first_) changed[i / chunk] = 1;
        nearest_[i] = now;
      }
    });
    first_ = false;
    return std::find(changed.begin(), changed.end(), 1) != changed.end();
  }

  /// Returns whether any center changed.
  bool move_centers() {
    std::vector<std::array<std::uint32_t, 256>> ones(centers_.size(), std::array<std::uint32_t, 256>{});
    std::vector<std::uint32_t> sizes(centers_.size(), 0);
    for (std::size_t i = 0; i < members_.size(); ++i) {
      auto& counts = ones[nearest_[i]];
      ++sizes[nearest_[i]];
      for (std::size_t word = 0; word < 4; ++word)
        for (std::size_t bit = 0; bit < 64; ++bit)
          counts[64 * word + bit] += static_cast<std::uint32_t>(member(i).words[word] >> bit & 1U);
    }
    bool moved = false;
    for (std::size_t c = 0; c < centers_.size(); ++c) {
      if (sizes[c] == 0) continue;
      Descriptor center;
      for (std::size_t bit = 0; bit < 256; ++bit)
        center.words[bit / 64] |= static_cast<std::uint64_t>(2 * ones[c][bit] > sizes[c]) << (bit % 64);
      moved = moved || !(center == centers_[c]);
      centers_[c] = center;
    }
    return moved;
  }

  const std::vector<Descriptor>& all_;
  const Members& members_;
  TaskPool* pool_;
  std::vector<Descriptor> centers_;
  std::vector<std::uint8_t> nearest_;  ///< Center of each member.
  bool first_ = true;
};

}  // namespace

/// Grows the tree level by level, so that nodes and their children are in order.
class VocabularyTrainer {
 public:
  VocabularyTrainer(std::span<const std::vector<Descriptor>> images, const VocabularyOptions& options, TaskPool* pool,
                    const std::function<void(double)>& progress)
      : options_(options), pool_(pool), progress_(progress) {
    for (std::size_t image = 0; image < images.size(); ++image) {
      all_.insert(all_.end(), images[image].begin(), images[image].end());
      image_of_.resize(all_.size(), static_cast<std::uint32_t>(image));
    }
    check(options, !all_.empty());
    made_.branching_ = options.branching;
    made_.depth_ = options.depth;
  }

  Vocabulary train(std::size_t images) {
    made_.nodes_.push_back({});
    made_.centers_.push_back({});
    members_.emplace_back(all_.size());
    for (std::size_t i = 0; i < all_.size(); ++i) members_[0][i] = static_cast<std::uint32_t>(i);
    std::size_t begin = 0;
    for (int level = 0; level < options_.depth; ++level) {
      const std::size_t end = made_.nodes_.size();
      divide(begin, end, level);
      begin = end;
    }
    made_.number_words();
    weigh(images);
    return std::move(made_);
  }

 private:
  using Clusters = std::vector<std::pair<Descriptor, Members>>;

  /// Divides the nodes begin..end-1 of one level.
  void divide(std::size_t begin, std::size_t end, int level) {
    std::vector<Clusters> divided(end - begin);
    const auto divide_one = [&](std::size_t i, TaskPool* pool) {
      const Members& members = members_[begin + i];
      if (members.size() > 1)
        divided[i] = Division(all_, members, options_, seed_for(options_.seed, begin + i), pool).clusters();
    };
    for (std::size_t i = 0; i < divided.size(); ++i)
      if (members_[begin + i].size() >= large) divide_one(i, pool_);
    for_chunks(pool_, divided.size(), 1, [&](int from, int to) {
      for (auto i = static_cast<std::size_t>(from); i < static_cast<std::size_t>(to); ++i)
        if (members_[begin + i].size() < large) divide_one(i, nullptr);
    });
    for (std::size_t i = 0; i < divided.size(); ++i) add_children(begin + i, divided[i]);
    if (progress_) progress_(static_cast<double>(level + 1) / options_.depth);
  }

  void add_children(std::size_t parent, Clusters& clusters) {
    if (clusters.size() < 2) return;  // Identical members are one word.
    made_.nodes_[parent].first_child = static_cast<std::uint32_t>(made_.nodes_.size());
    made_.nodes_[parent].children = static_cast<std::uint16_t>(clusters.size());
    const auto depth = static_cast<std::uint16_t>(made_.nodes_[parent].depth + 1);
    for (auto& [center, members] : clusters) {
      made_.nodes_.push_back({0, 0, depth, 0, 0.0F});
      made_.centers_.push_back(center);
      members_.push_back(std::move(members));
    }
    members_[parent] = {};
  }

  /// A word that occurs in few images is more distinctive.
  void weigh(std::size_t images) {
    for (std::size_t i = 0; i < made_.nodes_.size(); ++i) {
      if (made_.nodes_[i].children > 0) continue;
      Members in;
      for (const std::uint32_t member : members_[i]) in.push_back(image_of_[member]);
      in.erase(std::unique(in.begin(), in.end()), in.end());  // They ascend, as their descriptors do.
      // Counting one image more keeps the weight of a word in all images above zero.
      made_.nodes_[i].weight =
          static_cast<float>(std::log((static_cast<double>(images) + 1.0) / static_cast<double>(in.size())));
    }
  }

  VocabularyOptions options_;
  TaskPool* pool_;
  const std::function<void(double)>& progress_;
  std::vector<Descriptor> all_;
  std::vector<std::uint32_t> image_of_;  ///< Of each descriptor.
  Vocabulary made_;
  std::vector<Members> members_;  ///< Of each node that is not divided yet.
};

Vocabulary Vocabulary::train(std::span<const std::vector<Descriptor>> images, const VocabularyOptions& options,
                             TaskPool* pool, const std::function<void(double)>& progress) {
  return VocabularyTrainer(images, options, pool, progress).train(images.size());
}

}  // namespace rastro
