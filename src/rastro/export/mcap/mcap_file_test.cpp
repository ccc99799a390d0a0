// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/mcap/mcap_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/export/mcap/mcap_reader_testing.h"

namespace rastro {
namespace {

using testing::ElementsAre;
using testing::Pair;

constexpr std::string_view magic("\x89MCAP0\r\n", 8);
constexpr std::size_t footer_bytes = 9 + 20;

/// The definition of CRC-32, bit by bit.
std::uint32_t plain_crc(std::string_view bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char each : bytes) {
    crc ^= static_cast<std::uint8_t>(each);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0U ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

/// Seven messages of two topics, two of them with one schema; chunks of about three.
std::string small_file() {
  std::string bytes;
  McapFile file([&bytes](std::string_view piece) { bytes += piece; }, 300);
  file.add_metadata("rastro", {{"name", "room"}, {"unit", "meters"}});
  const auto pose = file.add_schema("foxglove.Pose", "descriptors of a pose");
  const auto log = file.add_schema("foxglove.Log", "descriptors of a log");
  const auto first = file.add_channel(pose, "/pose", {{"unit", "meters"}});
  const auto second = file.add_channel(log, "/log", {});
  for (int k = 0; k < 5; ++k) file.add_message(first, 1000 + 10 * k, std::string(80, static_cast<char>('a' + k)));
  file.add_message(second, 1035, "lost");
  file.add_message(second, 2000, "");
  file.finish();
  return bytes;
}

struct FooterRead {
  std::uint64_t summary, offsets;
  std::uint32_t crc;
};

FooterRead footer_of(std::string_view file) {
  McapCursor cursor(file.substr(file.size() - magic.size() - footer_bytes));
  EXPECT_EQ(cursor.number<std::uint8_t>(), 0x02);
  EXPECT_EQ(cursor.number<std::uint64_t>(), 20U);
  return {cursor.number<std::uint64_t>(), cursor.number<std::uint64_t>(), cursor.number<std::uint32_t>()};
}

std::vector<McapRecordAt> all_records(std::string_view file) {
  return mcap_records(file.substr(magic.size(), file.size() - 2 * magic.size()), magic.size());
}

std::vector<McapRecordAt> records_of(std::string_view file, std::uint8_t kind) {
  std::vector<McapRecordAt> found;
  for (const McapRecordAt& each : all_records(file))
    if (each.kind == kind) found.push_back(each);
  return found;
}

TEST(McapFile, BeginsAndEndsAsSpecified) {
  const std::string file = small_file();
  EXPECT_EQ(file.substr(0, 8), magic);
  EXPECT_EQ(file.substr(file.size() - 8), magic);
  const auto records = all_records(file);
  EXPECT_EQ(records.front().kind, 0x01);
  EXPECT_EQ(records.back().kind, 0x02);
  McapCursor header(records.front().content);
  EXPECT_EQ(header.text(), "") << "no profile";
  EXPECT_TRUE(header.text().starts_with("rastro "));
}

TEST(McapFile, HasItsMessages) {
  const std::string bytes = small_file();
  const McapFileRead file(bytes);
  ASSERT_EQ(file.messages.size(), 7U);
  const auto poses = file.of_topic("/pose");
  ASSERT_EQ(poses.size(), 5U);
  EXPECT_EQ(poses[4].data, std::string(80, 'e'));
  EXPECT_EQ(poses[4].time, 1040U);
  EXPECT_EQ(poses[4].sequence, 4U);
  EXPECT_EQ(file.of_topic("/log")[0].data, "lost");
  EXPECT_EQ(file.of_topic("/log")[1].data, "");
  EXPECT_EQ(file.schemas.at(1).name, "foxglove.Pose");
  EXPECT_EQ(file.schemas.at(1).encoding, "protobuf");
  EXPECT_EQ(file.schemas.at(2).data, "descriptors of a log");
  EXPECT_EQ(file.channels.at(1).encoding, "protobuf");
  EXPECT_THAT(file.channels.at(1).facts, ElementsAre(Pair("unit", "meters")));
  EXPECT_EQ(file.metadata.at("rastro").at("name"), "room");
}

TEST(McapFile, EveryCrcIsThatOfItsBytes) {
  const std::string file = small_file();
  const FooterRead footer = footer_of(file);
  const std::string_view all = file;
  EXPECT_EQ(footer.crc, plain_crc(all.substr(footer.summary, all.size() - magic.size() - 4 - footer.summary)));
  const auto end = records_of(file, 0x0F);
  ASSERT_EQ(end.size(), 1U);
  EXPECT_EQ(McapCursor(end[0].content).number<std::uint32_t>(), plain_crc(all.substr(0, end[0].offset)));
  const auto chunks = records_of(file, 0x06);
  ASSERT_GE(chunks.size(), 3U);
  for (const McapRecordAt& chunk : chunks) {
    McapCursor cursor(chunk.content);
    cursor.take(24);
    const auto crc = cursor.number<std::uint32_t>();
    EXPECT_EQ(cursor.text(), "") << "not compressed";
    EXPECT_EQ(crc, plain_crc(cursor.take(cursor.number<std::uint64_t>())));
    EXPECT_TRUE(cursor.empty());
  }
}

/// The message that an index entry of a chunk points at.
void expect_message_at(std::string_view records, std::uint64_t offset, std::uint16_t channel, std::uint64_t time) {
  McapCursor message(records.substr(offset));
  EXPECT_EQ(message.number<std::uint8_t>(), 0x05);
  message.number<std::uint64_t>();
  EXPECT_EQ(message.number<std::uint16_t>(), channel);
  message.number<std::uint32_t>();
  EXPECT_EQ(message.number<std::uint64_t>(), time);
}

/// Messages found by the index of one chunk, which `index` is.
std::size_t follow_chunk_index(std::string_view file, std::string_view index) {
  McapCursor cursor(index);
  const auto first = cursor.number<std::uint64_t>(), last = cursor.number<std::uint64_t>();
  const auto start = cursor.number<std::uint64_t>(), length = cursor.number<std::uint64_t>();
  McapCursor offsets(cursor.take(cursor.number<std::uint32_t>()));
  const auto indexes_length = cursor.number<std::uint64_t>();
  EXPECT_EQ(cursor.text(), "");
  const auto stored = cursor.number<std::uint64_t>(), whole = cursor.number<std::uint64_t>();
  EXPECT_EQ(stored, whole);
  const auto chunk = mcap_records(file.substr(start, length), start);
  EXPECT_EQ(chunk.size(), 1U);
  EXPECT_EQ(chunk[0].kind, 0x06);
  const std::string_view records = chunk[0].content.substr(chunk[0].content.size() - whole);
  std::size_t found = 0;
  while (!offsets.empty()) {
    const auto channel = offsets.number<std::uint16_t>();
    const auto at = offsets.number<std::uint64_t>();
    EXPECT_GE(at, start + length);
    EXPECT_LT(at, start + length + indexes_length);
    McapCursor record(file.substr(at));
    EXPECT_EQ(record.number<std::uint8_t>(), 0x07);
    record.number<std::uint64_t>();
    EXPECT_EQ(record.number<std::uint16_t>(), channel);
    McapCursor entries(record.take(record.number<std::uint32_t>()));
    for (; !entries.empty(); ++found) {
      const auto time = entries.number<std::uint64_t>();
      EXPECT_GE(time, first);
      EXPECT_LE(time, last);
      expect_message_at(records, entries.number<std::uint64_t>(), channel, time);
    }
  }
  return found;
}

TEST(McapFile, IndexesPointAtWhatTheySay) {
  const std::string file = small_file();
  const auto indexes = records_of(file, 0x08);
  EXPECT_EQ(indexes.size(), records_of(file, 0x06).size());
  std::size_t found = 0;
  for (const McapRecordAt& each : indexes) found += follow_chunk_index(file, each.content);
  EXPECT_EQ(found, 7U);
  const auto metadata = records_of(file, 0x0D);
  ASSERT_EQ(metadata.size(), 1U);
  McapCursor index(metadata[0].content);
  const auto offset = index.number<std::uint64_t>(), length = index.number<std::uint64_t>();
  EXPECT_EQ(index.text(), "rastro");
  EXPECT_EQ(records_of(file, 0x0C)[0].offset, offset);
  EXPECT_EQ(records_of(file, 0x0C)[0].bytes, length);
}

TEST(McapFile, StatisticsCount) {
  const std::string file = small_file();
  const auto records = records_of(file, 0x0B);
  ASSERT_EQ(records.size(), 1U);
  McapCursor cursor(records[0].content);
  EXPECT_EQ(cursor.number<std::uint64_t>(), 7U) << "messages";
  EXPECT_EQ(cursor.number<std::uint16_t>(), 2U) << "schemas";
  EXPECT_EQ(cursor.number<std::uint32_t>(), 2U) << "channels";
  EXPECT_EQ(cursor.number<std::uint32_t>(), 0U) << "attachments";
  EXPECT_EQ(cursor.number<std::uint32_t>(), 1U) << "metadata";
  EXPECT_EQ(cursor.number<std::uint32_t>(), records_of(file, 0x06).size()) << "chunks";
  EXPECT_EQ(cursor.number<std::uint64_t>(), 1000U);
  EXPECT_EQ(cursor.number<std::uint64_t>(), 2000U);
  EXPECT_EQ(cursor.number<std::uint32_t>(), 20U);
  EXPECT_EQ(cursor.number<std::uint16_t>(), 1U);
  EXPECT_EQ(cursor.number<std::uint64_t>(), 5U);
  EXPECT_EQ(cursor.number<std::uint16_t>(), 2U);
  EXPECT_EQ(cursor.number<std::uint64_t>(), 2U);
  EXPECT_TRUE(cursor.empty());
}

TEST(McapFile, SummaryOffsetsCoverItsGroups) {
  const std::string file = small_file();
  const FooterRead footer = footer_of(file);
  const auto end = records_of(file, 0x0F);
  EXPECT_EQ(end[0].offset + end[0].bytes, footer.summary);
  std::uint64_t next = footer.summary;
  std::vector<int> kinds;
  for (const McapRecordAt& each : records_of(file, 0x0E)) {
    EXPECT_GE(each.offset, footer.offsets);
    McapCursor cursor(each.content);
    kinds.push_back(cursor.number<std::uint8_t>());
    EXPECT_EQ(cursor.number<std::uint64_t>(), next);
    const auto length = cursor.number<std::uint64_t>();
    for (const McapRecordAt& inside : mcap_records(std::string_view(file).substr(next, length), next))
      EXPECT_EQ(inside.kind, kinds.back());
    next += length;
  }
  EXPECT_THAT(kinds, ElementsAre(0x03, 0x04, 0x0B, 0x08, 0x0D));
  EXPECT_EQ(next, footer.offsets);
}

TEST(McapFile, SameCallsGiveSameBytes) { EXPECT_EQ(small_file(), small_file()); }

TEST(McapFile, WithoutMessagesIsSoundToo) {
  std::string bytes;
  McapFile file([&bytes](std::string_view piece) { bytes += piece; });
  file.finish();
  EXPECT_TRUE(McapFileRead(bytes).messages.empty());
  EXPECT_TRUE(records_of(bytes, 0x06).empty());
  EXPECT_EQ(records_of(bytes, 0x0B).size(), 1U);
}

TEST(McapFile, RefusesWhatCannotBe) {
  McapFile file([](std::string_view) {});
  EXPECT_THROW(file.add_channel(1, "/pose", {}), std::logic_error);
  const auto channel = file.add_channel(file.add_schema("foxglove.Pose", ""), "/pose", {});
  EXPECT_THROW(file.add_message(channel, -1, ""), std::logic_error);
  EXPECT_THROW(file.add_message(9, 0, ""), std::logic_error);
}

}  // namespace
}  // namespace rastro
