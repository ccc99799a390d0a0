// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/database.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/hash.h"
#include "rastro/base/regular_file.h"
#include "rastro/map/file/bytes.h"

namespace rastro {
namespace {

constexpr std::size_t header_size = 100;
constexpr int longest_row = 256 << 20;

constexpr std::string_view layer_prefix = "layer_";
constexpr const char* tables_of_depth_cameras[] = {"head",  "keyframes", "pictures", "poses",
                                                   "edges", "way",       "contents"};
constexpr const char* tables_of_landmarks[] = {"head", "keyframes", "poses", "landmarks", "ties", "way", "contents"};
constexpr const char* tables_of_layers[] = {"head",        "cameras", "sessions", "keyframes",
                                            "constraints", "frames",  "layers",   "contents"};

bool is_layer_table(std::string_view name) {
  constexpr std::size_t longest = 64;
  return name.starts_with(layer_prefix) && name.size() > layer_prefix.size() && name.size() <= longest &&
         std::all_of(name.begin(), name.end(), [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; });
}

std::string create_statement(std::string_view table) {
  // The checksum is before the body, so that it can be read without reading images.
  return fmt::format("CREATE TABLE {} (id INTEGER PRIMARY KEY, checksum INTEGER NOT NULL, body BLOB NOT NULL)", table);
}

/// A number of SQLite's header, which is big-endian.
std::uint64_t header_number(std::string_view header, std::size_t at, std::size_t size) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < size; ++i) number = number << 8 | static_cast<unsigned char>(header[at + i]);
  return number;
}

bool has_log(const std::string& file) {
  std::error_code code;
  return std::filesystem::exists(file + "-wal", code);
}

/// Reports what can be determined without SQLite, in plain language.
std::uint32_t check_header(const std::string& file) {
  require_regular_file(file, std::numeric_limits<std::uintmax_t>::max());
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw Error("cannot be read", file, "check the path");
  std::string header(header_size, '\0');
  stream.read(header.data(), static_cast<std::streamsize>(header_size));
  if (static_cast<std::size_t>(stream.gcount()) < header_size ||
      !header.starts_with(std::string("SQLite format 3\0", 16)) || header_number(header, 68, 4) != map_file_id) {
    throw Error("is not a map of rastro", file, "give the map.rastro of a run; if it was one, try 'rastro recover'");
  }
  const std::uint64_t version = header_number(header, 60, 4);
  if (version == 0) refuse_damaged(file, "does not say its version");
  if (version > map_file_version) {
    throw Error(fmt::format("is a map of version {}, and this program knows {}", version, map_file_version), file,
                "use a newer rastro");
  }
  std::uint64_t page = header_number(header, 16, 2);
  if (page == 1) page = 65'536;
  const std::uint64_t wanted = page * header_number(header, 28, 4);
  std::error_code code;
  const std::uint64_t size = std::filesystem::file_size(file, code);
  if (!has_log(file) && size < wanted)
    refuse_damaged(file, fmt::format("is cut off after {} of {} bytes", size, wanted));
  return static_cast<std::uint32_t>(version);
}

/// `file` as a URI that SQLite resolves to exactly this file.
std::string uri_of(const std::string& file, bool immutable) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(file).string()) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (byte >= '0' && byte <= '9') || (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') ||
                       byte == '/' || byte == '.' || byte == '_' || byte == '-';
    uri += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return uri + (immutable ? "?immutable=1" : "");
}

}  // namespace

Database Database::open(const std::filesystem::path& file) {
  Database database(file);
  database.version_ = check_header(file.string());
  // Without a log beside it the file is complete and has no writer: no locks and no files next to it are needed.
  database.connect(uri_of(file.string(), !has_log(file.string())), SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
  database.check_tables();
  return database;
}

std::span<const char* const> tables_of_version(std::uint32_t version) {
  if (version == 1) return tables_of_depth_cameras;
  if (version == 2) return tables_of_landmarks;
  return tables_of_layers;
}

std::string table_of_layer(std::string_view layer) { return std::string(layer_prefix) + std::string(layer); }

std::int64_t row_checksum(std::string_view table, std::int64_t id, std::string_view body) {
  ByteWriter begin;
  begin.put_text(table);
  begin.put(id);
  Sha256 hash;
  hash.add(begin.take());
  hash.add(body);
  const std::string digits = hash.finish();
  std::uint64_t value = 0;
  std::from_chars(digits.data(), digits.data() + 16, value, 16);
  return static_cast<std::int64_t>(value);
}

Database Database::create(const std::filesystem::path& file) {
  for (const char* ending : {"", "-wal", "-shm"}) {
    std::error_code code;
    std::filesystem::remove(file.string() + ending, code);
  }
  Database database(file);
  database.connect(uri_of(file.string(), false), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_URI);
  // Freed space is zeroed, so that the bytes of a file depend on its content alone.
  database.run(
      "PRAGMA page_size=4096; PRAGMA secure_delete=ON; PRAGMA journal_mode=MEMORY; PRAGMA synchronous=OFF; BEGIN");
  database.run(fmt::format("PRAGMA application_id={}; PRAGMA user_version={}", map_file_id, map_file_version).c_str());
  for (const char* table : tables_of_version(map_file_version)) database.need_table(table);
  database.run("COMMIT");
  return database;
}

void Database::checkpoint(const std::filesystem::path& file) {
  Database database(file);
  database.connect(uri_of(file.string(), false), SQLITE_OPEN_READWRITE | SQLITE_OPEN_URI);
  database.run("PRAGMA wal_checkpoint(PASSIVE)");
}

Database::Database(Database&& other) noexcept { *this = std::move(other); }

Database& Database::operator=(Database&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(version_, other.version_);
  std::swap(tables_, other.tables_);
  std::swap(connection_, other.connection_);
  std::swap(bytes_put_, other.bytes_put_);
  std::swap(put_, other.put_);
  return *this;
}

Database::~Database() {
  for (const auto& [table, statement] : put_) sqlite3_finalize(statement);
  sqlite3_close(connection_);
}

void Database::connect(const std::string& name, int flags) {
  const int code = sqlite3_open_v2(name.c_str(), &connection_, flags | SQLITE_OPEN_NOMUTEX, nullptr);
  if (code != SQLITE_OK) fail(code);
  harden();
}

/// A map may come from anywhere: its content is only data.
void Database::harden() {
  sqlite3_db_config(connection_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(connection_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(connection_, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(connection_, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_limit(connection_, SQLITE_LIMIT_LENGTH, longest_row);
  sqlite3_busy_timeout(connection_, 2000);
  run("PRAGMA cell_size_check=ON; PRAGMA mmap_size=0");
}

/// Every file has the tables of its version first; newer ones have those of layers after them.
void Database::check_tables() {
  const auto wanted = tables_of_version(version_);
  sqlite3_stmt* statement = nullptr;
  int code =
      sqlite3_prepare_v2(connection_, "SELECT name, sql FROM sqlite_master ORDER BY rowid", -1, &statement, nullptr);
  bool sound = code == SQLITE_OK;
  while (sound && (code = sqlite3_step(statement)) == SQLITE_ROW) {
    const auto* name = reinterpret_cast<const char*>(sqlite3_column_text(statement, 0));
    const auto* sql = reinterpret_cast<const char*>(sqlite3_column_text(statement, 1));
    sound = name && sql && create_statement(name) == sql &&
            (tables_.size() < wanted.size() ? std::string_view(wanted[tables_.size()]) == name
                                            : version_ >= 3 && is_layer_table(name));
    if (sound) tables_.emplace_back(name);
  }
  sqlite3_finalize(statement);
  if (code == SQLITE_BUSY || code == SQLITE_CANTOPEN) fail(code);
  if (!sound || code != SQLITE_DONE || tables_.size() < wanted.size()) refuse_damaged(file_);
}

void Database::need_table(const std::string& table) {
  if (std::find(tables_.begin(), tables_.end(), table) != tables_.end()) return;
  run(create_statement(table).c_str());
  tables_.push_back(table);
}

void Database::run(const char* sql) {
  const int code = sqlite3_exec(connection_, sql, nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code);
}

void Database::put(const std::string& table, std::int64_t id, std::string_view body) {
  sqlite3_stmt*& statement = put_[table];
  if (!statement) {
    const std::string sql = fmt::format("INSERT OR REPLACE INTO {} VALUES (?, ?, ?)", table);
    const int code = sqlite3_prepare_v3(connection_, sql.c_str(), -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
    if (code != SQLITE_OK) fail(code);
  }
  sqlite3_bind_int64(statement, 1, id);
  sqlite3_bind_int64(statement, 2, row_checksum(table, id, body));
  sqlite3_bind_blob64(statement, 3, body.data(), body.size(), SQLITE_STATIC);
  const int code = sqlite3_step(statement);
  sqlite3_reset(statement);
  sqlite3_clear_bindings(statement);
  if (code != SQLITE_DONE) fail(code);
  bytes_put_ += body.size();
}

void Database::remove(const std::string& table, std::int64_t id) {
  run(fmt::format("DELETE FROM {} WHERE id={}", table, id).c_str());
}

void Database::clear(const std::string& table) { run(fmt::format("DELETE FROM {}", table).c_str()); }

void Database::fail(int code) const {
  switch (code & 0xFF) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_TOOBIG:
    case SQLITE_ERROR:
    case SQLITE_FORMAT:
      refuse_damaged(file_);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw Error("is in use by another program", file_, "try again when that has ended");
    case SQLITE_FULL:
      throw Error("cannot be written: the disk is full", file_, "make room or choose another --out");
    case SQLITE_NOMEM:
      throw Error("needs more memory than there is", file_, "close other programs");
    default:
      throw Error(fmt::format("cannot be read or written ({})", sqlite3_errstr(code)), file_,
                  "check permissions and the disk");
  }
}

RowReader::RowReader(const Database& database, const std::string& table, std::int64_t first, What what)
    : database_(database), table_(table) {
  const std::string sql =
      fmt::format("SELECT id, checksum{} FROM {} WHERE id >= ? ORDER BY id", what == What::all ? ", body" : "", table);
  const int code = sqlite3_prepare_v2(database.connection_, sql.c_str(), -1, &statement_, nullptr);
  if (code != SQLITE_OK) database.fail(code);
  sqlite3_bind_int64(statement_, 1, first);
}

RowReader::~RowReader() { sqlite3_finalize(statement_); }

bool RowReader::next() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_DONE) return false;
  if (code != SQLITE_ROW) database_.fail(code);
  const std::int64_t id = sqlite3_column_int64(statement_, 0);
  if (id <= id_) refuse_damaged(database_.file());
  id_ = id;
  return true;
}

std::int64_t RowReader::checksum() const { return sqlite3_column_int64(statement_, 1); }

std::string_view RowReader::body() const {
  if (sqlite3_column_type(statement_, 2) != SQLITE_BLOB) refuse_damaged(where());
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_, 2));
  const std::string_view body(bytes ? bytes : "", static_cast<std::size_t>(sqlite3_column_bytes(statement_, 2)));
  if (row_checksum(table_, id_, body) != checksum()) refuse_damaged(where());
  return body;
}

std::string RowReader::where() const { return fmt::format("{}: row {} of {}", database_.file(), id_, table_); }

std::optional<std::string> row_of(const Database& database, const std::string& table, std::int64_t id) {
  RowReader rows(database, table, id);
  if (!rows.next() || rows.id() != id) return std::nullopt;
  return std::string(rows.body());
}

}  // namespace rastro
