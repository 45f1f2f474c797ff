// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/error.h>

#include <sqlite3.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

/** \file
 * A thin, owning C++ face of SQLite, private to io. Errors are IoError with the file's name. */

namespace facetloc::sqlite {

using Blob = std::vector<std::uint8_t>;

/** \brief An open database, for one thread at a time. */
class Connection {
public:
  /** \param shown the file that errors speak of, where it is another one */
  Connection(const std::filesystem::path& path, int flags, const std::filesystem::path& shown = {})
      : name_(shown.empty() ? path.string() : shown.string()) {
    constexpr int kBusyTimeout = 5000;              // [ms] another process may be writing
    constexpr int kLargestCell = 64 * 1024 * 1024;  // [bytes] a corrupt file may claim any size
    sqlite3* db = nullptr;
    const int status = sqlite3_open_v2(path.string().c_str(), &db,
                                       flags | SQLITE_OPEN_EXRESCODE | SQLITE_OPEN_NOMUTEX, nullptr);
    db_.reset(db);
    if (status != SQLITE_OK) fail("cannot be opened");
    sqlite3_busy_timeout(db, kBusyTimeout);
    sqlite3_limit(db, SQLITE_LIMIT_LENGTH, kLargestCell);
    sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  }

  void execute(const std::string& sql) {
    if (sqlite3_exec(handle(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
  }
  sqlite3* handle() const { return db_.get(); }
  const std::string& name() const { return name_; }
  int lastCode() const { return sqlite3_extended_errcode(handle()); }
  /** \brief Throws WriteError in the system's words, if it is the disk that fails, else IoError. */
  [[noreturn]] void fail(const std::string& doing = "database error") const {
    const int code = db_ ? lastCode() & 0xFF : SQLITE_NOMEM;
    const int system = db_ ? sqlite3_system_errno(handle()) : 0;
    if (code == SQLITE_FULL) throw WriteError(name_, std::generic_category().message(ENOSPC));
    if (db_ && lastCode() == SQLITE_IOERR_WRITE)
      throw WriteError(name_, system ? std::generic_category().message(system) : sqlite3_errmsg(handle()));
    throw IoError(name_, fmt::format("{}: {}", doing, db_ ? sqlite3_errmsg(handle()) : "out of memory"));
  }

private:
  struct Close {
    void operator()(sqlite3* db) const { sqlite3_close_v2(db); }
  };
  std::string name_;
  std::unique_ptr<sqlite3, Close> db_;
};

/** \brief A cell does not hold a valid value of its column. */
class BadCell : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/** \brief Does work on a file, and makes its BadCell an IoError: the cause, and the fault. */
template <typename Work>
auto naming(const std::string& file, const std::string& cause, const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const BadCell& e) {
    throw IoError(file, cause + e.what());
  }
}

/** \brief A prepared statement. Values are bound, and cells of a row are read, one after the other. */
class Statement {
public:
  Statement(Connection& db, const std::string& sql) : db_(db) {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(db.handle(), sql.c_str(), -1, &statement, nullptr) != SQLITE_OK) db.fail();
    statement_.reset(statement);
  }

  Statement& operator<<(double value) { return check(sqlite3_bind_double(get(), ++bound_, value)); }
  Statement& operator<<(int value) { return check(sqlite3_bind_int(get(), ++bound_, value)); }
  Statement& operator<<(std::nullptr_t) { return check(sqlite3_bind_null(get(), ++bound_)); }
  Statement& operator<<(const std::string& value) {
    return check(
        sqlite3_bind_text(get(), ++bound_, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT));
  }
  Statement& operator<<(const Blob& value) {
    // Without data SQLite would bind NULL.
    const void* data = value.empty() ? static_cast<const void*>("") : value.data();
    return check(sqlite3_bind_blob(get(), ++bound_, data, static_cast<int>(value.size()), SQLITE_TRANSIENT));
  }
  Statement& operator<<(const std::optional<double>& value) {
    return value ? *this << *value : *this << nullptr;
  }
  template <typename Range>
  Statement& bindAll(const Range& values) {
    for (const auto& value : values) *this << value;
    return *this;
  }
  Statement& bindNulls(int cells) {
    for (int i = 0; i < cells; ++i) *this << nullptr;
    return *this;
  }

  /** \brief Goes to the next row; false after the last. */
  bool step() {
    cell_ = 0;
    const int status = sqlite3_step(get());
    if (status != SQLITE_ROW && status != SQLITE_DONE) db_.fail();
    return status == SQLITE_ROW;
  }
  /** \brief Runs a statement that returns no rows, and makes it ready for the next values. */
  void run() {
    step();
    reset();
  }
  /** \brief Makes it ready for the next values. */
  void reset() {
    sqlite3_reset(get());
    bound_ = 0;
  }

  bool isNull() const { return sqlite3_column_type(get(), cell_) == SQLITE_NULL; }
  void skip(int cells) { cell_ += cells; }
  double real() {
    const int type = sqlite3_column_type(get(), cell_);
    if (type != SQLITE_FLOAT && type != SQLITE_INTEGER) bad("is not a number");
    return sqlite3_column_double(get(), cell_++);
  }
  std::optional<double> realOrNull() {
    if (!isNull()) return real();
    skip(1);
    return {};
  }
  template <std::size_t N>
  std::array<double, N> reals() {
    std::array<double, N> values;
    for (double& value : values) value = real();
    return values;
  }
  int integer() {
    const std::int64_t value = large();
    if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
      --cell_;
      bad("is out of range");
    }
    return static_cast<int>(value);
  }
  std::int64_t large() {
    if (sqlite3_column_type(get(), cell_) != SQLITE_INTEGER) bad("is not an integer");
    return sqlite3_column_int64(get(), cell_++);
  }
  std::string text() {
    if (sqlite3_column_type(get(), cell_) != SQLITE_TEXT) bad("is not a text");
    const auto* data = reinterpret_cast<const char*>(sqlite3_column_text(get(), cell_));
    const int size = sqlite3_column_bytes(get(), cell_++);
    return data ? std::string(data, size) : std::string();
  }
  Blob blob() {
    if (sqlite3_column_type(get(), cell_) != SQLITE_BLOB) bad("is not a blob");
    const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(get(), cell_));
    const int size = sqlite3_column_bytes(get(), cell_++);
    return data ? Blob(data, data + size) : Blob();
  }

private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  sqlite3_stmt* get() const { return statement_.get(); }
  Statement& check(int status) {
    if (status != SQLITE_OK) db_.fail();
    return *this;
  }
  [[noreturn]] void bad(const char* what) const {
    const char* column = sqlite3_column_name(get(), cell_);
    throw BadCell(fmt::format("column {} {}", column ? column : "?", what));
  }

  Connection& db_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  int bound_ = 0;
  int cell_ = 0;
};

/** \brief All or nothing: rolled back unless committed. All that is read while it lives is of one time. */
class Transaction {
public:
  explicit Transaction(Connection& db, const char* begin = "BEGIN IMMEDIATE") : db_(db) {
    db_.execute(begin);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  ~Transaction() {
    if (!committed_) sqlite3_exec(db_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
  void commit() {
    db_.execute("COMMIT");
    committed_ = true;
  }

private:
  Connection& db_;
  bool committed_ = false;
};

}  // namespace facetloc::sqlite
