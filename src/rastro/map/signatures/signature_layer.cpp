// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/signatures/signature_layer.h"

#include <fmt/format.h>

#include "rastro/map/file/bytes.h"
#include "rastro/map/file/feature_bytes.h"

namespace rastro {
namespace {

Signature read_signature(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  Signature signature;
  signature.words.resize(bytes.count(sizeof(std::int64_t)));
  for (std::int64_t& word : signature.words) {
    word = bytes.get<std::int64_t>();
    bytes.check(word >= -1);
  }
  signature.image = get_image_features(bytes);
  bytes.check(signature.words.size() <= signature.image->features.size());
  bytes.finish();
  return signature;
}

class SignatureLayerType : public StoredLayerType<SignatureLayer, Signature> {
 public:
  std::string body_of(const Signature& signature) const override { return rastro::body_of(signature); }
  Signature item_of(std::string_view body, const std::string& where) const override {
    return read_signature(body, where);
  }
  LayerDescription describe(const Map&, const Layer& layer) const override {
    const std::size_t count = typed(layer).keyframes.size();
    return {fmt::format("signatures of {} keyframes", count), {{"signatures", static_cast<double>(count)}}};
  }
};

}  // namespace

std::string body_of(const Signature& signature) {
  ByteWriter bytes;
  bytes.put(static_cast<std::uint32_t>(signature.words.size()));
  for (const std::int64_t word : signature.words) bytes.put(word);
  put(bytes, *signature.image);
  return bytes.take();
}

std::shared_ptr<const SignatureStore> signatures_in(std::shared_ptr<const RowStore> rows) {
  static const SignatureLayerType type;
  return type.in_file(std::move(rows));
}

std::unique_ptr<LayerType> signatures_layer_type() { return std::make_unique<SignatureLayerType>(); }

}  // namespace rastro
