// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/id_table.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace rastro {
namespace {

TEST(IdTable, EqualsAMapUnderRandomAdditionsAndRemovals) {
  std::mt19937 random(3);
  IdTable<std::int64_t> table;
  std::map<std::int64_t, const std::int64_t*> expected;
  for (int i = 0; i < 5000; ++i) {
    const std::int64_t id = table.end_id() + (random() % 50 == 0 ? static_cast<std::int64_t>(random() % 700) : 0);
    expected[id] = &table.add(id, std::make_unique<std::int64_t>(id));
    EXPECT_EQ(table.end_id(), id + 1);
    const auto gone = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(id + 1));
    table.remove(gone);
    expected.erase(gone);
  }
  for (std::int64_t id = -2; id < table.end_id() + 300; ++id) {
    const auto found = expected.find(id);
    ASSERT_EQ(table.find(id), found == expected.end() ? nullptr : found->second) << id;
  }
  auto next = expected.begin();
  table.for_each([&](const std::int64_t& id) { EXPECT_EQ(id, (next++)->first); });
  EXPECT_EQ(next, expected.end());
}

TEST(IdTable, GoesOnAfterEverythingIsRemoved) {
  IdTable<int> table;
  for (int id = 0; id < 1000; ++id) table.add(id, std::make_unique<int>(id));
  for (int id = 0; id < 1000; ++id) table.remove(id);
  table.remove(17);
  EXPECT_EQ(table.end_id(), 1000);
  EXPECT_EQ(table.find(999), nullptr);
  table.add(1000, std::make_unique<int>(7));
  EXPECT_EQ(*table.find(1000), 7);
}

/// A landmark of thirty lasts.
TEST(IdTable, TheFewThatStayTakeLittleMemory) {
  IdTable<int> table;
  constexpr int ids = 60000, every = 30, kept = ids / every;
  for (int id = 0; id < ids; ++id) {
    table.add(id, std::make_unique<int>(id));
    if (id >= 300 && (id - 300) % every != 0) table.remove(id - 300);
  }
  EXPECT_LE(table.bytes(), ids / 2U + (2U * kept + 2U * 300U) * sizeof(int*));
  for (int id = ids - 300; id < ids; ++id) table.remove(id);
  int found = 0;
  table.for_each([&](const int& id) { EXPECT_EQ(id, every * found++); });
  EXPECT_EQ(found, kept - 10);
}

/// Neither other additions nor removals move an object.
TEST(IdTable, AddressesStay) {
  IdTable<int> table;
  std::map<int, const int*> expected;
  for (int id = 0; id < 500; ++id) expected[id] = &table.add(id, std::make_unique<int>(id));
  for (int id = 0; id < 500; ++id) {
    if (id % 7 == 3) continue;
    table.remove(id);
    expected.erase(id);
    for (const auto& [left, address] : expected) ASSERT_EQ(table.find(left), address) << id;
  }
}

}  // namespace
}  // namespace rastro
