// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/feature/brief.h"

namespace rastro {

/// An image as a bag of visual words (Sivic and Zisserman 2003).
struct BagOfWords {
  std::vector<std::pair<std::uint32_t, float>> words;  ///< Word and its weight; words ascend, weights sum to 1.
  /// One per feature: its node in the tree at the requested depth. Only features of the same node need to be compared
  /// between two images (direct index).
  std::vector<std::uint32_t> nodes;
};

/// Similarity of two images, 0..1: 1 - |a - b|_1 / 2 (Galvez-Lopez and Tardos 2012, equation 2).
double similarity(const BagOfWords& a, const BagOfWords& b);

struct VocabularyOptions {
  int branching = 10;      ///< Children of a node, 2..64.
  int depth = 5;           ///< Levels below the root, 1..8.
  int rounds = 12;         ///< Iterations of k-majority at each node, at most.
  std::uint64_t seed = 1;  ///< For the initial centers.
};

/// A tree of binary words (Nister and Stewenius 2006 for binary descriptors, as Galvez-Lopez and Tardos 2012): each
/// node's children are the centers of its descriptors, by k-majority. Immutable; thread-safe.
class Vocabulary {
 public:
  /// Trains a vocabulary from the descriptors of each image. Words are weighted by the logarithm of the number of
  /// images over the number that contain it. Throws Error without images or descriptors, and for options out of range.
  /// `progress`, if any, receives the share done, 0..1. The result does not depend on the pool.
  static Vocabulary train(std::span<const std::vector<Descriptor>> images, const VocabularyOptions& options,
                          TaskPool* pool = nullptr, const std::function<void(double)>& progress = {});
  /// Reads rastro's format (.rvoc) or the text format of DBoW2 and DBoW3, detected by content. Throws Error if it is
  /// neither or damaged.
  static Vocabulary read(const std::filesystem::path& file);
  /// The same from memory; `where` is named in errors.
  static Vocabulary parse(std::string_view bytes, const std::string& where);
  /// Writes rastro's format: the same vocabulary gives the same bytes. Throws Error if it cannot be written.
  void write(const std::filesystem::path& file) const;
  std::string bytes() const;

  int branching() const { return branching_; }
  int depth() const { return depth_; }
  std::size_t words() const { return words_; }
  std::size_t nodes() const { return centers_.size(); }

  /// Each feature's word, with its weight times its count, normalized to a sum of 1. `node_depth` (1..depth) is that of
  /// BagOfWords::nodes: 0 is the root; a tree that is not as deep is marked at its words.
  BagOfWords words_of(std::span<const Descriptor> descriptors, int node_depth = 2) const;

 private:
  Vocabulary() = default;
  struct Node {
    std::uint32_t first_child = 0;  ///< Children are contiguous; a word has none.
    std::uint16_t children = 0;
    std::uint16_t depth = 0;
    std::uint32_t word = 0;  ///< Of a leaf: its index.
    float weight = 0.0F;     ///< Of a leaf.
  };
  friend class VocabularyTrainer;
  friend class VocabularyReader;
  /// Numbers the leaves in the order of the nodes.
  void number_words();

  int branching_ = 0;
  int depth_ = 0;
  std::size_t words_ = 0;
  std::vector<Node> nodes_;          ///< Level by level; the root first.
  std::vector<Descriptor> centers_;  ///< One per node; the root's is unused.
};

/// The built-in vocabulary, trained on generated images only (scripts/train_vocabulary). Loaded on the first call; the
/// same object afterwards.
std::shared_ptr<const Vocabulary> standard_vocabulary();

}  // namespace rastro
