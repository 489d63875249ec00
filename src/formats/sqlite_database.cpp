#include "formats/sqlite_database.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>

#include "loopstone/formats/log_reader.hpp"

namespace loopstone {
namespace {

constexpr int kStepsBetweenQuestions = 20'000;

int ask_to_stop(void* stop) { return (*static_cast<const std::function<bool()>*>(stop))() ? 1 : 0; }

/// A name as the path of a "file:" address.
std::string address_of(const std::string& path) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  constexpr std::string_view kPlain = "/-_.";
  std::string address = path.starts_with('/') ? "file://" : "file:";
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') ||
                          (byte >= '0' && byte <= '9') || kPlain.find(c) != kPlain.npos;
    if (is_plain) {
      address += c;
    } else {
      address += '%';
      address += kHex[byte >> 4];
      address += kHex[byte & 15];
    }
  }
  return address;
}

/// What a connection begins with.
const char* words_of(SqliteAccess access) {
  switch (access) {
    case SqliteAccess::kCreate:
      return "PRAGMA page_size=4096; PRAGMA journal_mode=OFF; PRAGMA synchronous=OFF;"
             "PRAGMA locking_mode=EXCLUSIVE; PRAGMA cache_size=-8192;";
    case SqliteAccess::kWrite:
      return "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON;"
             "PRAGMA cell_size_check=ON;";
    case SqliteAccess::kUntouched:
    case SqliteAccess::kRecover:
    case SqliteAccess::kRead:
      break;
  }
  return "PRAGMA query_only=ON; PRAGMA cache_size=-8192; PRAGMA mmap_size=0;"
         "PRAGMA temp_store=MEMORY; PRAGMA cell_size_check=ON;";
}

constexpr std::size_t kPageSizeAt = 16;

/// Of a database that begins like this; 0 when it says none that there is.
std::uint64_t page_bytes(const unsigned char* size) {
  const std::uint64_t page = std::uint64_t{size[0]} << 8 | size[1];
  if (page == 1) return 65'536;
  return page >= 512 && (page & (page - 1)) == 0 ? page : 0;
}

/// SQLite takes a page that is cut off for a whole one, whose rest is zeros: messages would come
/// with false bytes. To it, files have only whole pages.
class WholePages {
 public:
  /// For sqlite3_open_v2(); null when there are no files on this machine.
  static const char* name() {
    static const WholePages whole;
    return whole.is_registered_ ? kName : nullptr;
  }

 private:
  static constexpr const char* kName = "loopstone-whole-pages";

  WholePages() {
    original_files = sqlite3_vfs_find(nullptr);
    if (original_files == nullptr) return;
    own_files = *original_files;
    own_files.zName = kName;
    own_files.pNext = nullptr;
    own_files.xOpen = open;
    is_registered_ = sqlite3_vfs_register(&own_files, 0) == SQLITE_OK;
  }

  static int open(sqlite3_vfs* own, sqlite3_filename name, sqlite3_file* file, int flags,
                  int* opened_flags) {
    const int code = original_files->xOpen(own, name, file, flags, opened_flags);
    if (code != SQLITE_OK || (flags & SQLITE_OPEN_MAIN_DB) == 0) return code;
    // Of files that are not locked there is one table of functions.
    static const sqlite3_io_methods* const plain = file->pMethods;
    static const sqlite3_io_methods changed = [] {
      plain_methods = plain;
      sqlite3_io_methods methods = *plain;
      methods.xFileSize = size_of;
      return methods;
    }();
    if (file->pMethods == plain) file->pMethods = &changed;
    return code;
  }

  static int size_of(sqlite3_file* file, sqlite3_int64* size) {
    const sqlite3_io_methods& plain = *plain_methods;
    const int code = plain.xFileSize(file, size);
    unsigned char head[2] = {};
    if (code != SQLITE_OK || *size < 512 ||
        plain.xRead(file, head, sizeof head, kPageSizeAt) != SQLITE_OK) {
      return code;
    }
    const auto page = static_cast<sqlite3_int64>(page_bytes(head));
    if (page > 0) *size -= *size % page;
    return code;
  }

  static inline sqlite3_vfs* original_files = nullptr;
  static inline sqlite3_vfs own_files{};
  static inline const sqlite3_io_methods* plain_methods = nullptr;
  bool is_registered_ = false;
};

}  // namespace

SqliteDatabase::SqliteDatabase(const std::string& path, const SqliteOptions& options)
    : stop_(options.stop) {
  std::string address = address_of(path);
  int flags = SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
  switch (options.access) {
    case SqliteAccess::kUntouched:
      flags |= SQLITE_OPEN_READONLY;
      address += "?immutable=1";
      break;
    case SqliteAccess::kRecover:
      flags |= SQLITE_OPEN_READWRITE;
      break;
    case SqliteAccess::kCreate:
    case SqliteAccess::kWrite:
      flags |= SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
      break;
    case SqliteAccess::kRead:
      flags |= SQLITE_OPEN_READONLY;
      break;
  }
  const char* files = options.access == SqliteAccess::kUntouched ? WholePages::name() : nullptr;
  const int code = sqlite3_open_v2(address.c_str(), &handle_, flags, files);
  if (code != SQLITE_OK) fail(code);
  configure(options);
}

SqliteDatabase::SqliteDatabase(std::string_view bytes, const SqliteOptions& options)
    : stop_(options.stop) {
  if (bytes.size() > kPageSizeAt + 1) {
    const auto* head = reinterpret_cast<const unsigned char*>(bytes.data());
    const std::uint64_t page = page_bytes(head + kPageSizeAt);
    if (page > 0) bytes.remove_suffix(bytes.size() % page);
  }
  int code =
      sqlite3_open_v2(":memory:", &handle_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
  if (code != SQLITE_OK) fail(code);
  auto* copy =
      static_cast<unsigned char*>(sqlite3_malloc64(std::max<std::size_t>(1, bytes.size())));
  if (copy == nullptr) {
    sqlite3_close_v2(handle_);
    throw std::bad_alloc();
  }
  std::memcpy(copy, bytes.data(), bytes.size());
  // Memory has no log beside it: both versions of the format say "journal".
  constexpr std::size_t kFormats = 18;
  if (bytes.size() > kFormats + 1) copy[kFormats] = copy[kFormats + 1] = 1;
  const auto size = static_cast<sqlite3_int64>(bytes.size());
  code = sqlite3_deserialize(handle_, "main", copy, size, size,
                             SQLITE_DESERIALIZE_FREEONCLOSE | SQLITE_DESERIALIZE_READONLY);
  if (code != SQLITE_OK) fail(code);
  configure(options);
}

SqliteDatabase::~SqliteDatabase() { sqlite3_close_v2(handle_); }

void SqliteDatabase::fail(int code) {
  const std::string reason = handle_ != nullptr ? sqlite3_errmsg(handle_) : sqlite3_errstr(code);
  sqlite3_close_v2(handle_);
  handle_ = nullptr;
  throw SqliteError(code & 0xFF, reason);
}

void SqliteDatabase::configure(const SqliteOptions& options) {
  const auto set = [this](int option, int value) {
    sqlite3_db_config(handle_, option, value, nullptr);
  };
  set(SQLITE_DBCONFIG_DEFENSIVE, options.is_tolerant ? 0 : 1);
  set(SQLITE_DBCONFIG_WRITABLE_SCHEMA, options.is_tolerant ? 1 : 0);
  set(SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0);
  set(SQLITE_DBCONFIG_ENABLE_TRIGGER, 0);
  set(SQLITE_DBCONFIG_ENABLE_VIEW, 0);
  set(SQLITE_DBCONFIG_ENABLE_LOAD_EXTENSION, 0);
  set(SQLITE_DBCONFIG_DQS_DML, 0);
  set(SQLITE_DBCONFIG_DQS_DDL, 0);
  constexpr std::uint64_t kMost = 1'000'000'000;
  sqlite3_limit(handle_, SQLITE_LIMIT_LENGTH,
                static_cast<int>(std::min(kMost, options.most_value_bytes)));
  // VACUUM attaches the database that it writes.
  sqlite3_limit(handle_, SQLITE_LIMIT_ATTACHED, options.access == SqliteAccess::kWrite ? 1 : 0);
  sqlite3_limit(handle_, SQLITE_LIMIT_WORKER_THREADS, 0);
  if (stop_) sqlite3_progress_handler(handle_, kStepsBetweenQuestions, ask_to_stop, &stop_);
  try {
    run(words_of(options.access));
  } catch (...) {
    sqlite3_close_v2(handle_);
    handle_ = nullptr;
    throw;
  }
}

void SqliteDatabase::run(const std::string& sql) {
  const int code = sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr);
  if (code == SQLITE_OK) return;
  if ((code & 0xFF) == SQLITE_INTERRUPT) throw ReadingStopped();
  throw SqliteError(code & 0xFF, sqlite3_errmsg(handle_));
}

SqliteStatement::SqliteStatement(SqliteDatabase& database, const std::string& sql)
    : database_(database) {
  const int code = sqlite3_prepare_v3(database_.handle(), sql.c_str(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &handle_, nullptr);
  if (code != SQLITE_OK) fail(code);
}

SqliteStatement::~SqliteStatement() { sqlite3_finalize(handle_); }

void SqliteStatement::fail(int code) {
  if ((code & 0xFF) == SQLITE_INTERRUPT) throw ReadingStopped();
  throw SqliteError(code & 0xFF, sqlite3_errmsg(database_.handle()));
}

void SqliteStatement::bind(int parameter, std::int64_t value) {
  const int code = sqlite3_bind_int64(handle_, parameter, value);
  if (code != SQLITE_OK) fail(code);
}

void SqliteStatement::bind_real(int parameter, double value) {
  const int code = sqlite3_bind_double(handle_, parameter, value);
  if (code != SQLITE_OK) fail(code);
}

void SqliteStatement::bind_text(int parameter, std::string_view text) {
  const int code = sqlite3_bind_text64(handle_, parameter, text.empty() ? "" : text.data(),
                                       text.size(), SQLITE_STATIC, SQLITE_UTF8);
  if (code != SQLITE_OK) fail(code);
}

void SqliteStatement::bind_blob(int parameter, std::span<const char> bytes) {
  const int code = sqlite3_bind_blob64(handle_, parameter, bytes.empty() ? "" : bytes.data(),
                                       bytes.size(), SQLITE_STATIC);
  if (code != SQLITE_OK) fail(code);
}

bool SqliteStatement::step() {
  const int code = sqlite3_step(handle_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  fail(code);
}

void SqliteStatement::reset() noexcept { sqlite3_reset(handle_); }

std::int64_t SqliteStatement::integer(int column) const {
  return sqlite3_column_int64(handle_, column);
}

double SqliteStatement::real(int column) const { return sqlite3_column_double(handle_, column); }

std::string_view SqliteStatement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(handle_, column));
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
}

std::span<const char> SqliteStatement::blob(int column) const {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(handle_, column));
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
}

bool SqliteStatement::is_null(int column) const {
  return sqlite3_column_type(handle_, column) == SQLITE_NULL;
}

std::string sqlite_name(std::string_view name) {
  std::string quoted = "\"";
  for (const char c : name) {
    quoted += c;
    if (c == '"') quoted += c;
  }
  return quoted + '"';
}

}  // namespace loopstone
