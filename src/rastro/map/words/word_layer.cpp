// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/words/word_layer.h"

#include <fmt/format.h>

#include "rastro/map/file/bytes.h"

namespace rastro {
namespace {

class WordLayerType : public KeyframeLayerType<WordLayer, BagOfWords> {
 public:
  std::string header(const Layer& layer) const override {
    ByteWriter bytes;
    bytes.put_text(typed(layer).vocabulary);
    return bytes.take();
  }
  std::shared_ptr<Layer> make(std::string_view header, const std::string& where) const override {
    ByteReader bytes(header, where);
    auto words = std::make_shared<WordLayer>();
    words->vocabulary = bytes.text();
    bytes.finish();
    return words;
  }

  std::string body_of(const BagOfWords& bag) const override {
    ByteWriter bytes;
    bytes.put(static_cast<std::uint32_t>(bag.words.size()));
    for (const auto& [word, share] : bag.words) {
      bytes.put(word);
      bytes.put(share);
    }
    bytes.put(static_cast<std::uint32_t>(bag.nodes.size()));
    for (const std::uint32_t node : bag.nodes) bytes.put(node);
    return bytes.take();
  }
  std::shared_ptr<const BagOfWords> thing_of(KeyframeId, std::string_view body,
                                             const std::string& where) const override {
    ByteReader bytes(body, where);
    auto bag = std::make_shared<BagOfWords>();
    bag->words.resize(bytes.count(sizeof(std::uint32_t) + sizeof(float)));
    std::int64_t last = -1;
    for (auto& [word, share] : bag->words) {
      word = bytes.get<std::uint32_t>();
      share = bytes.get<float>();
      bytes.check(static_cast<std::int64_t>(word) > last && share >= 0.0F);
      last = word;
    }
    bag->nodes.resize(bytes.count(sizeof(std::uint32_t)));
    for (std::uint32_t& node : bag->nodes) node = bytes.get<std::uint32_t>();
    bytes.finish();
    return bag;
  }

  LayerDescription describe(const Map&, const Layer& layer) const override {
    std::size_t count = 0;
    for (const auto& [id, bag] : typed(layer).of) count += bag->words.size();
    return {fmt::format("{} visual words in {} keyframes", count, typed(layer).of.size()),
            {{"words", static_cast<double>(count)}}};
  }
};

}  // namespace

std::unique_ptr<LayerType> words_layer_type() { return std::make_unique<WordLayerType>(); }

}  // namespace rastro
