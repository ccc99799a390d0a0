// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>

#include "rastro/base/error.h"
#include "rastro/base/hash.h"
#include "rastro/base/text_file.h"
#include "rastro/place/vocabulary.h"
#include "rastro/place/vocabulary_text.h"

namespace rastro {
namespace {

static_assert(std::endian::native == std::endian::little, "vocabularies are little-endian");

constexpr std::string_view magic = "RASTROVOC";
constexpr std::uint8_t version = 1;

[[noreturn]] void refuse(const std::string& where, std::string_view what) {
  throw Error(what, where, "make it again with 'rastro vocabulary', or download it again");
}

/// The first eight digits of SHA-256.
std::uint32_t checksum(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return static_cast<std::uint32_t>(std::stoul(hash.finish().substr(0, 8), nullptr, 16));
}

template <typename Number>
void put(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace

/// rastro's format: magic, version, branching and depth (a byte each), number of nodes (4), then for each node, level
/// by level, its number of children (a byte); centers of all but the root (32 bytes each); weights of the words (4
/// each); the checksum of all before (4).
class VocabularyReader {
 public:
  VocabularyReader(std::string_view bytes, const std::string& where) : bytes_(bytes), where_(where) {}

  Vocabulary read() {
    const std::string_view all = bytes_;
    take(magic.size());
    if (get<std::uint8_t>() != version) refuse(where_, "is a vocabulary of a newer version of rastro");
    made_.branching_ = get<std::uint8_t>();
    made_.depth_ = get<std::uint8_t>();
    const std::size_t count = get<std::uint32_t>();
    check(all.size() >= 4 && count > 0 && count <= all.size() / sizeof(Descriptor) + 1);
    if (count == 1) refuse(where_, "has no words");  // The root is none.
    std::uint32_t stored = 0;
    std::memcpy(&stored, all.data() + all.size() - 4, 4);
    check(stored == checksum(all.substr(0, all.size() - 4)));
    read_tree(count);
    made_.centers_.resize(count);
    const std::string_view centers = take((count - 1) * sizeof(Descriptor));
    if (!centers.empty()) std::memcpy(made_.centers_.data() + 1, centers.data(), centers.size());
    for (auto& node : made_.nodes_) {
      if (node.children > 0) continue;
      node.weight = get<float>();
      check(node.weight >= 0.0F && node.weight <= max_word_weight);
    }
    check(bytes_.size() == 4);
    made_.number_words();
    return std::move(made_);
  }

  /// From the nodes of a text format, in any order.
  static Vocabulary from_text(const VocabularyText& text, const std::string& where) {
    Vocabulary made;
    made.branching_ = text.branching;
    made.depth_ = text.depth;
    made.nodes_.push_back({});
    made.centers_.push_back({});
    std::vector<std::size_t> entry_of{text.entries.size()};  // The root has none.
    for (std::size_t at = 0; at < made.nodes_.size(); ++at) {
      const auto children = text.children_of(at == 0 ? 0 : text.entries[entry_of[at]].id);
      if (children.size() > 255) refuse(where, "has a node with more than 255 children");
      made.nodes_[at].first_child = static_cast<std::uint32_t>(made.nodes_.size());
      made.nodes_[at].children = static_cast<std::uint16_t>(children.size());
      const auto depth = static_cast<std::uint16_t>(made.nodes_[at].depth + 1);
      if (!children.empty() && depth > made.depth_) refuse(where, "has nodes deeper than its header says");
      for (const VocabularyText::Entry& child : children) {
        made.nodes_.push_back({0, 0, depth, 0, child.weight});
        made.centers_.push_back(child.descriptor);
        entry_of.push_back(static_cast<std::size_t>(&child - text.entries.data()));
      }
    }
    if (made.nodes_.size() != text.entries.size() + 1) refuse(where, "has nodes that are not connected to the root");
    if (made.nodes_.size() < 2) refuse(where, "has no words");
    made.number_words();
    return made;
  }

 private:
  void check(bool sound) const {
    if (!sound) refuse(where_, "is damaged");
  }
  std::string_view take(std::size_t size) {
    check(size <= bytes_.size());
    const std::string_view piece = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return piece;
  }
  template <typename Number>
  Number get() {
    Number number;
    std::memcpy(&number, take(sizeof number).data(), sizeof number);
    return number;
  }

  void read_tree(std::size_t count) {
    made_.nodes_.resize(count);
    std::size_t next = 1;
    const std::string_view children = take(count);
    for (std::size_t i = 0; i < count; ++i) {
      check(i == 0 || i < next);  // Every node but the root is a child.
      auto& node = made_.nodes_[i];
      node.children = static_cast<std::uint8_t>(children[i]);
      node.first_child = static_cast<std::uint32_t>(next);
      check(node.children <= count - next && (node.children == 0 || node.depth < made_.depth_));
      for (std::size_t c = next; c < next + node.children; ++c)
        made_.nodes_[c].depth = static_cast<std::uint16_t>(node.depth + 1);
      next += node.children;
    }
    check(next == count);
  }

  std::string_view bytes_;
  const std::string& where_;
  Vocabulary made_;
};

Vocabulary Vocabulary::parse(std::string_view bytes, const std::string& where) {
  if (bytes.starts_with(magic)) return VocabularyReader(bytes, where).read();
  return VocabularyReader::from_text(VocabularyText::parse(bytes, where), where);
}

Vocabulary Vocabulary::read(const std::filesystem::path& file) {
  return parse(read_text_file(file.string()), file.string());
}

std::string Vocabulary::bytes() const {
  std::string bytes(magic);
  put(bytes, version);
  put(bytes, static_cast<std::uint8_t>(branching_));
  put(bytes, static_cast<std::uint8_t>(depth_));
  put(bytes, static_cast<std::uint32_t>(nodes_.size()));
  for (const Node& node : nodes_) put(bytes, static_cast<std::uint8_t>(node.children));
  bytes.append(reinterpret_cast<const char*>(centers_.data() + 1), (centers_.size() - 1) * sizeof(Descriptor));
  for (const Node& node : nodes_)
    if (node.children == 0) put(bytes, node.weight);
  put(bytes, checksum(bytes));
  return bytes;
}

void Vocabulary::write(const std::filesystem::path& file) const {
  std::ofstream out(file, std::ios::binary);
  const std::string all = bytes();
  out.write(all.data(), static_cast<std::streamsize>(all.size()));
  out.flush();
  if (!out) throw Error("cannot be written", file.string(), "choose another path with --out, or free some space");
}

}  // namespace rastro
