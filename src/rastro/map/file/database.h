// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

namespace rastro {

/// The application id "RSTR" of map files among SQLite files, and the newest version of their content: 1 maps of a
/// depth camera, 2 maps of landmarks, 3 maps with layers, 4 the same with depth images as
/// pack_depth() makes them.
constexpr std::uint32_t map_file_id = 0x52535452;
constexpr std::uint32_t map_file_version = 4;

/// The tables that every file of a version has, in the order of their creation.
std::span<const char* const> tables_of_version(std::uint32_t version);
/// "layer_images" for the layer `images`.
std::string table_of_layer(std::string_view layer);

/// Over the whole row, including the table's name: a row in the wrong table fails the check.
std::int64_t row_checksum(std::string_view table, std::int64_t id, std::string_view body);

/// One connection to the SQLite file of a map. Every failure is an Error naming the file. Not thread-safe.
class Database {
 public:
  /// Opens an existing map for reading. Error for a file that is no map, has a newer version, is truncated or has other
  /// tables.
  static Database open(const std::filesystem::path& file);
  /// Creates a file with empty tables; replaces an existing one.
  static Database create(const std::filesystem::path& file);
  /// Moves what is committed from a file's log into the file itself, while others read and write.
  static void checkpoint(const std::filesystem::path& file);
  Database(Database&& other) noexcept;
  Database& operator=(Database&& other) noexcept;
  ~Database();

  const std::string& file() const { return file_; }
  std::uint32_t version() const { return version_; }
  /// All of them, those of layers last, in the order of their creation.
  const std::vector<std::string>& tables() const { return tables_; }
  /// Creates an empty table if there is none of that name.
  void need_table(const std::string& table);
  void run(const char* sql);
  /// Adds the row, or replaces it.
  void put(const std::string& table, std::int64_t id, std::string_view body);
  void remove(const std::string& table, std::int64_t id);
  void clear(const std::string& table);
  std::size_t bytes_put() const { return bytes_put_; }  ///< By all calls of put().

 private:
  friend class RowReader;
  explicit Database(const std::filesystem::path& file) : file_(file.string()) {}
  void connect(const std::string& name, int flags);
  void harden();
  void check_tables();
  [[noreturn]] void fail(int code) const;

  std::string file_;
  std::uint32_t version_ = map_file_version;
  std::vector<std::string> tables_;
  sqlite3* connection_ = nullptr;
  std::size_t bytes_put_ = 0;
  std::map<std::string, sqlite3_stmt*> put_;  ///< By table.
};

/// Reads the rows of one table in the order of their ids. Throws Error for a row that fails its checksum.
class RowReader {
 public:
  enum class What { all, checksums };
  /// From row `first` on. Where checksums are enough, bodies are not read from disk.
  RowReader(const Database& database, const std::string& table, std::int64_t first = 0, What what = What::all);
  ~RowReader();
  RowReader(const RowReader&) = delete;
  RowReader& operator=(const RowReader&) = delete;

  /// Advances to the next row; false at the end.
  bool next();
  std::int64_t id() const { return id_; }
  std::int64_t checksum() const;
  /// Verified. Valid until the next call of next().
  std::string_view body() const;
  /// "FILE: row 3 of keyframes", for messages.
  std::string where() const;

 private:
  const Database& database_;
  std::string table_;
  sqlite3_stmt* statement_ = nullptr;
  std::int64_t id_ = -1;
};

/// The body of one row; nullopt where there is none.
std::optional<std::string> row_of(const Database& database, const std::string& table, std::int64_t id);

}  // namespace rastro
