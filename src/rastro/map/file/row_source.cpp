// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/row_source.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/map/file/bytes.h"

namespace rastro {

std::string FileRows::row(std::int64_t id) const {
  const std::lock_guard lock(file_->mutex);
  RASTRO_CHECK(file_->database.has_value(), "the map file of these rows is open");
  auto row = row_of(*file_->database, table_, id);
  if (!row) refuse_damaged(file_->database->file(), fmt::format("lacks row {} of {}", id, table_));
  return std::move(*row);
}

void SoundRows::each(const std::string& table, const Read& read) {
  for (RowReader rows(*shared_->database, table); rows.next();) read(rows.body(), rows.id(), rows.where());
}

std::shared_ptr<const RowStore> SoundRows::stored(const std::string& table) {
  return std::make_shared<FileRows>(shared_, table);
}

void SoundRows::each_id(const std::string& table, const std::function<void(std::int64_t)>& read) {
  for (RowReader rows(*shared_->database, table, 0, RowReader::What::checksums); rows.next();) read(rows.id());
}

void FoundRows::each(const std::string& table, const Read& read) {
  for (const auto& [id, body] : rows_[table]) {
    try {
      read(body, id, name_);
    } catch (const Error&) {
      ++refused_[table];
    }
  }
}

void FoundRows::each_id(const std::string& table, const std::function<void(std::int64_t)>& read) {
  for (const auto& [id, body] : rows_[table]) read(id);
}

std::int64_t FoundRows::refused(const std::string& table) const {
  const auto found = refused_.find(table);
  return found == refused_.end() ? 0 : found->second;
}

}  // namespace rastro
