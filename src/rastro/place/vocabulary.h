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

/// A picture as a bag of visual words (Sivic and Zisserman 2003).
struct BagOfWords {
  std::vector<std::pair<std::uint32_t, float>> words;  ///< Word and its share; words ascend, shares sum to 1.
  /// One a feature: the node of the tree it falls under, at the depth asked for. Two pictures' features of one node are
  /// worth comparing.
  std::vector<std::uint32_t> nodes;
};

/// How alike two pictures are, 0..1: 1 - |a - b|_1 / 2 (Galvez-Lopez and Tardos 2012, equation 2).
double similarity(const BagOfWords& a, const BagOfWords& b);

struct VocabularyOptions {
  int branching = 10;      ///< Children of a node, 2..64.
  int depth = 5;           ///< Levels below the root, 1..8.
  int rounds = 12;         ///< Of k-majority at each node, at most.
  std::uint64_t seed = 1;  ///< Of the choice of first centres.
};

/// A tree of binary words (Nister and Stewenius 2006 on bits, as Galvez-Lopez and Tardos 2012): each node's children
/// are the centres of its descriptors, by k-majority. Never changes once made; may be read by many threads at once.
class Vocabulary {
 public:
  /// From the descriptors of each picture; words are weighted by the logarithm of pictures over pictures that have it.
  /// Error without pictures or descriptors, and for options out of range. `progress`, if any, is told the share done,
  /// 0..1. The result does not depend on the pool.
  static Vocabulary train(std::span<const std::vector<Descriptor>> images, const VocabularyOptions& options,
                          TaskPool* pool = nullptr, const std::function<void(double)>& progress = {});
  /// Own form (.rvoc) or the text form of DBoW2 and DBoW3, told by content. Error where it is neither or is damaged.
  static Vocabulary read(const std::filesystem::path& file);
  /// The same of bytes; `where` is named in errors.
  static Vocabulary parse(std::string_view bytes, const std::string& where);
  /// Own form: the same vocabulary gives the same bytes. Error where it cannot be written.
  void write(const std::filesystem::path& file) const;
  std::string bytes() const;

  int branching() const { return branching_; }
  int depth() const { return depth_; }
  std::size_t words() const { return words_; }
  std::size_t nodes() const { return centres_.size(); }

  /// Each feature's word, with its weight times its count over all features' sum. `node_depth` (1..depth) is that of
  /// BagOfWords::nodes: 0 is the root.
  BagOfWords words_of(std::span<const Descriptor> descriptors, int node_depth = 2) const;

 private:
  Vocabulary() = default;
  struct Node {
    std::uint32_t first_child = 0;  ///< Children lie one after the other; none for a word.
    std::uint16_t children = 0;
    std::uint16_t depth = 0;
    std::uint32_t word = 0;  ///< Of a leaf: its number.
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
  std::vector<Descriptor> centres_;  ///< One a node; the root's means nothing.
};

/// The vocabulary that comes with rastro: compiled in, made of generated pictures only (scripts/train_vocabulary). Read
/// on the first call; the same object afterwards.
std::shared_ptr<const Vocabulary> standard_vocabulary();

}  // namespace rastro
