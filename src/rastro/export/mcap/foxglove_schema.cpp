// SPDX-License-Identifier: Apache-2.0
#if RASTRO_WITH_MCAP
#include <foxglove.pb.h>
#include <google/protobuf/descriptor.pb.h>

#include <string_view>

#include "rastro/export/mcap/foxglove_messages.h"

namespace rastro::detail {
namespace {

using google::protobuf::DescriptorProto;
using google::protobuf::FileDescriptor;
using google::protobuf::FileDescriptorProto;
using google::protobuf::FileDescriptorSet;

/// Names here begin with rastro.foxglove, those of readers with foxglove.
void use_package_of_readers(FileDescriptorProto& file) {
  constexpr std::string_view ours = ".rastro.foxglove.", outer = ".rastro";
  file.set_package("foxglove");
  for (DescriptorProto& message : *file.mutable_message_type())
    for (auto& field : *message.mutable_field())
      if (field.type_name().starts_with(ours)) field.set_type_name(field.type_name().substr(outer.size()));
}

/// What a file imports stands before it.
void add_file(const FileDescriptor& file, FileDescriptorSet& set) {
  for (const FileDescriptorProto& there : set.file())
    if (there.name() == file.name()) return;
  for (int k = 0; k < file.dependency_count(); ++k) add_file(*file.dependency(k), set);
  file.CopyTo(set.add_file());
}

}  // namespace

std::string foxglove_schemas() {
  FileDescriptorSet set;
  add_file(*foxglove::Pose::descriptor()->file(), set);
  use_package_of_readers(*set.mutable_file()->rbegin());
  return set.SerializeAsString();
}

}  // namespace rastro::detail
#endif
