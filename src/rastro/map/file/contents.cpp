// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/contents.h"

#include "rastro/base/hash.h"
#include "rastro/map/file/bytes.h"

namespace rastro {

std::string contents_body(const Database& database) {
  ByteWriter bytes;
  for (const std::string& table : database.tables()) {
    if (table == "contents") continue;
    Sha256 hash;
    std::int64_t rows = 0;
    for (RowReader reader(database, table, 0, RowReader::What::checksums); reader.next(); ++rows) {
      ByteWriter checksum;
      checksum.put(reader.checksum());
      hash.add(checksum.take());
    }
    bytes.put_text(table);
    bytes.put(rows);
    bytes.put_text(hash.finish());
  }
  return bytes.take();
}

bool is_finished(const Database& database) {
  const auto contents = row_of(database, "contents", contents_row);
  if (contents && *contents != contents_body(database))
    refuse_damaged(database.file(), "does not hold what its table of contents says");
  return contents.has_value();
}

}  // namespace rastro
