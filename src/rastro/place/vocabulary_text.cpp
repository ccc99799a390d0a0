// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/vocabulary_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <tuple>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"

namespace rastro {
namespace {

constexpr std::size_t descriptor_bytes = 32;

[[noreturn]] void refuse(const std::string& where, std::string_view what) {
  throw Error(what, where,
              "use a vocabulary of 'rastro vocabulary', or of DBoW2 or DBoW3 for ORB (text or unpacked YAML)");
}

/// Consecutive numbers separated by spaces.
class Numbers {
 public:
  explicit Numbers(std::string_view text) : rest_(text) {}

  template <typename Number>
  std::optional<Number> next() {
    const std::size_t begin = rest_.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return std::nullopt;
    Number number{};
    const auto [end, failure] = std::from_chars(rest_.data() + begin, rest_.data() + rest_.size(), number);
    if (failure != std::errc{}) return std::nullopt;
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return number;
  }
  bool skip(std::string_view word) {
    const std::size_t begin = rest_.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos || !rest_.substr(begin).starts_with(word)) return false;
    rest_.remove_prefix(begin + word.size());
    return true;
  }
  bool at_end() const { return rest_.find_first_not_of(" \t\r\n") == std::string_view::npos; }

 private:
  std::string_view rest_;
};

std::optional<Descriptor> read_descriptor(Numbers& numbers) {
  Descriptor descriptor;
  for (std::size_t i = 0; i < descriptor_bytes; ++i) {
    const auto byte = numbers.next<unsigned>();
    if (!byte || *byte > 255) return std::nullopt;
    descriptor.words[i / 8] |= static_cast<std::uint64_t>(*byte) << (8 * (i % 8));
  }
  return descriptor;
}

std::optional<float> read_weight(Numbers& numbers) {
  const auto weight = numbers.next<float>();
  return weight && *weight >= 0.0F && *weight <= max_word_weight ? weight : std::nullopt;
}

bool is_shape(std::optional<int> branching, std::optional<int> depth) {
  return branching && depth && *branching >= 2 && *branching <= 255 && *depth >= 1 && *depth <= 16;
}

VocabularyText parse_lines(std::string_view text, const std::string& where) {
  VocabularyText made;
  std::uint32_t id = 0;
  bool first = true;
  int line_number = 0;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    ++line_number;
    Numbers numbers(line);
    if (numbers.at_end()) continue;
    if (first) {
      const auto branching = numbers.next<int>(), depth = numbers.next<int>();
      if (!is_shape(branching, depth)) refuse(where, "is not a vocabulary");
      made.branching = *branching;
      made.depth = *depth;
      first = false;
      continue;
    }
    const auto parent = numbers.next<std::uint32_t>();
    const auto is_word = numbers.next<int>();
    const auto descriptor = read_descriptor(numbers);
    const auto weight = read_weight(numbers);
    if (!parent || !is_word || !descriptor || !weight || !numbers.at_end())
      refuse(at_line(where, line_number), "is not a node of a vocabulary");
    made.entries.push_back({++id, *parent, *weight, *descriptor});
  }
  return made;
}

/// The text after the next `key`, which is removed from `text` with all before it; nothing if there is none.
std::optional<Numbers> after(std::string_view& text, std::string_view key) {
  const std::size_t at = text.find(key);
  if (at == std::string_view::npos) return std::nullopt;
  text.remove_prefix(at + key.size());
  return Numbers(text.substr(0, 1024));
}

VocabularyText parse_yaml(std::string_view text, const std::string& where) {
  VocabularyText made;
  auto branching = after(text, " k:"), depth = after(text, " L:");
  if (!branching || !depth) refuse(where, "is not a vocabulary");
  const auto k = branching->next<int>(), l = depth->next<int>();
  if (!is_shape(k, l)) refuse(where, "is not a vocabulary");
  made.branching = *k;
  made.depth = *l;
  while (auto id_text = after(text, "nodeId:")) {
    // The list of words after that of nodes names nodes too.
    if (text.substr(0, 200).find("parentId:") == std::string_view::npos) break;
    auto parent_text = after(text, "parentId:"), weight_text = after(text, "weight:"),
         descriptor_text = after(text, "descriptor:");
    const auto id = id_text->next<std::uint32_t>();
    const auto refuse_node = [&] {
      refuse(where, fmt::format("has a broken node after {} others", made.entries.size()));
    };
    if (!id || !parent_text || !weight_text || !descriptor_text || !descriptor_text->skip("\"")) refuse_node();
    // DBoW3 begins with the matrix type and its width.
    if (descriptor_text->skip("dbw3") && (descriptor_text->next<int>() != 0 || descriptor_text->next<int>() != 32))
      refuse(where, "has words that are not ORB descriptors");
    const auto parent = parent_text->next<std::uint32_t>();
    const auto weight = read_weight(*weight_text);
    const auto descriptor = read_descriptor(*descriptor_text);
    if (!parent || !weight || !descriptor) refuse_node();
    made.entries.push_back({*id, *parent, *weight, *descriptor});
  }
  return made;
}

}  // namespace

VocabularyText VocabularyText::parse(std::string_view text, const std::string& where) {
  VocabularyText made = text.starts_with("%YAML") ? parse_yaml(text, where) : parse_lines(text, where);
  const auto key = [](const Entry& entry) { return std::make_pair(entry.parent, entry.id); };
  std::sort(made.entries.begin(), made.entries.end(), [&](const Entry& a, const Entry& b) { return key(a) < key(b); });
  std::vector<std::uint32_t> ids;
  for (const Entry& entry : made.entries) ids.push_back(entry.id);
  std::sort(ids.begin(), ids.end());
  if (!ids.empty() && (ids.front() == 0 || std::adjacent_find(ids.begin(), ids.end()) != ids.end()))
    refuse(where, "has two nodes with the same number");
  return made;
}

std::span<const VocabularyText::Entry> VocabularyText::children_of(std::uint32_t id) const {
  const auto before = [](const Entry& entry, std::uint32_t parent) { return entry.parent < parent; };
  const auto begin = std::lower_bound(entries.begin(), entries.end(), id, before);
  auto end = begin;
  while (end != entries.end() && end->parent == id) ++end;
  return {begin, end};
}

}  // namespace rastro
