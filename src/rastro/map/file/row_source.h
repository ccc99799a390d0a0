// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "rastro/map/file/database.h"
#include "rastro/map/layer_type.h"

namespace rastro {

/// The connection to a map file that several threads read and write; each must hold the mutex.
struct SharedDatabase {
  mutable std::mutex mutex;
  std::optional<Database> database;
};

/// Rows of one table that stay in the file.
class FileRows : public RowStore {
 public:
  FileRows(std::shared_ptr<const SharedDatabase> file, std::string table)
      : file_(std::move(file)), table_(std::move(table)) {}
  std::string row(std::int64_t id) const override;

 private:
  std::shared_ptr<const SharedDatabase> file_;
  std::string table_;
};

/// The source of the rows of a map: a valid file, or what was found in a damaged one.
class RowSource {
 public:
  using Read = std::function<void(std::string_view body, std::int64_t id, const std::string& where)>;

  virtual ~RowSource() = default;
  virtual const std::string& file() const = 0;
  /// Each row of a table, in the order of their ids.
  virtual void each(const std::string& table, const Read& read) = 0;
  /// For rows that stay in the file; null where they must be read.
  virtual std::shared_ptr<const RowStore> stored(const std::string& table) = 0;
  /// Ids of a table without its bodies.
  virtual void each_id(const std::string& table, const std::function<void(std::int64_t)>& read) = 0;
};

/// A file in which every row is valid; else Error.
class SoundRows : public RowSource {
 public:
  explicit SoundRows(std::shared_ptr<const SharedDatabase> file)
      : shared_(std::move(file)), name_(shared_->database->file()) {}
  const std::string& file() const override { return name_; }
  void each(const std::string& table, const Read& read) override;
  std::shared_ptr<const RowStore> stored(const std::string& table) override;
  void each_id(const std::string& table, const std::function<void(std::int64_t)>& read) override;

 private:
  std::shared_ptr<const SharedDatabase> shared_;
  std::string name_;
};

/// What was found in a damaged file: a row that cannot be read costs that row alone.
class FoundRows : public RowSource {
 public:
  using Rows = std::map<std::int64_t, std::string>;
  explicit FoundRows(std::string file) : name_(std::move(file)) {}
  Rows& of(const std::string& table) { return rows_[table]; }
  const std::string& file() const override { return name_; }
  void each(const std::string& table, const Read& read) override;
  std::shared_ptr<const RowStore> stored(const std::string&) override { return nullptr; }
  void each_id(const std::string& table, const std::function<void(std::int64_t)>& read) override;
  /// Number of rows of a table that each() could not read.
  std::int64_t refused(const std::string& table) const;

 private:
  std::string name_;
  std::map<std::string, Rows> rows_;
  std::map<std::string, std::int64_t> refused_;
};

}  // namespace rastro
