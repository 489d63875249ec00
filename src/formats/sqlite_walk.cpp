#include "formats/sqlite_walk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace loopstone {
namespace {

constexpr std::int64_t kLastRow = std::numeric_limits<std::int64_t>::max();

std::string messages_text(std::int64_t count) {
  return count == 1 ? "a message" : fmt::format("{} messages", count);
}

}  // namespace

SqliteWalk::SqliteWalk(SqliteDatabase& database, std::optional<std::string> index,
                       std::function<void(const std::string&)> told)
    : database_(database), index_(std::move(index)), told_(std::move(told)) {
  rewind();
}

void SqliteWalk::rewind() {
  by_time_.reset();
  by_row_.reset();
  in_index_.reset();
  last_time_ns_.reset();
  walked_ = 0;
  left_out_ = 0;
  lost_ = 0;
  if (!index_) return begin_rows(Phase::kByRow);
  phase_ = Phase::kByTime;
  try {
    by_time_ = std::make_unique<SqliteStatement>(
        database_, "SELECT timestamp, _rowid_ FROM messages INDEXED BY " + sqlite_name(*index_) +
                       " ORDER BY timestamp");
  } catch (const SqliteError& error) {
    leave_index(error.what());
  }
}

void SqliteWalk::begin_rows(Phase phase) {
  by_time_.reset();
  phase_ = phase;
  last_row_.reset();
  is_at_row_ = false;
  try {
    by_row_ = std::make_unique<SqliteStatement>(
        database_,
        "SELECT timestamp, _rowid_ FROM messages NOT INDEXED WHERE _rowid_ >= ?1 "
        "ORDER BY _rowid_");
    by_row_->bind(1, std::numeric_limits<std::int64_t>::min());
  } catch (const SqliteError& error) {
    told_("its messages can't be read (" + std::string(error.what()) + ")");
    phase_ = Phase::kEnd;
  }
}

void SqliteWalk::leave_index(const std::string& reason) {
  tell_lost();
  told_("the index of its times is damaged (" + reason +
        "); what follows comes in the order in which it was recorded");
  begin_rows(Phase::kByRow);
}

std::optional<std::int64_t> SqliteWalk::next() {
  while (phase_ != Phase::kEnd) {
    const auto row = phase_ == Phase::kByTime ? next_by_time() : next_by_row();
    if (row) return row;
  }
  tell_lost();
  return std::nullopt;
}

std::optional<std::int64_t> SqliteWalk::next_by_time() {
  try {
    if (by_time_->step()) {
      const std::int64_t time_ns = by_time_->integer(0);
      const std::int64_t row = by_time_->integer(1);
      // A damaged tree may lead in circles.
      if (last_time_ns_ && std::pair(time_ns, row) <= std::pair(*last_time_ns_, last_time_row_)) {
        leave_index("it is not in order");
        return std::nullopt;
      }
      last_time_ns_ = time_ns;
      last_time_row_ = row;
      least_row_ = walked_ == 0 ? row : std::min(least_row_, row);
      greatest_row_ = walked_ == 0 ? row : std::max(greatest_row_, row);
      ++walked_;
      return row;
    }
    if (index_is_complete()) {
      phase_ = Phase::kEnd;
    } else {
      tell_lost();
      begin_rows(Phase::kLeftOut);
    }
  } catch (const SqliteError& error) {
    leave_index(error.what());
  }
  return std::nullopt;
}

/// Counting is a walk through the file; numbers without a gap make it unnecessary.
bool SqliteWalk::index_is_complete() {
  try {
    SqliteStatement last(database_,
                         "SELECT _rowid_ FROM messages NOT INDEXED ORDER BY _rowid_ DESC LIMIT 1");
    if (!last.step()) return walked_ == 0;
    const std::int64_t row = last.integer(0);
    SqliteStatement first(database_,
                          "SELECT _rowid_ FROM messages NOT INDEXED ORDER BY _rowid_ LIMIT 1");
    if (!first.step() || walked_ == 0) return false;
    const std::int64_t first_row = first.integer(0);
    const auto span = static_cast<std::uint64_t>(row) - static_cast<std::uint64_t>(first_row);
    if (row == greatest_row_ && first_row == least_row_ &&
        span + 1 == static_cast<std::uint64_t>(walked_)) {
      return true;
    }
    SqliteStatement count(database_, "SELECT count(*) FROM messages NOT INDEXED");
    return count.step() && count.integer(0) <= walked_;
  } catch (const SqliteError&) {
    return false;
  }
}

bool SqliteWalk::was_given(std::int64_t time_ns, std::int64_t row) {
  if (phase_ == Phase::kByRow) {
    return last_time_ns_ && std::pair(time_ns, row) <= std::pair(*last_time_ns_, last_time_row_);
  }
  try {
    if (!in_index_) {
      in_index_ = std::make_unique<SqliteStatement>(
          database_, "SELECT 1 FROM messages INDEXED BY " + sqlite_name(*index_) +
                         " WHERE timestamp = ?1 AND _rowid_ = ?2");
    }
    in_index_->reset();
    in_index_->bind(1, time_ns);
    in_index_->bind(2, row);
    return in_index_->step();
  } catch (const SqliteError&) {
    return false;  // what was not found there was not given
  }
}

std::optional<std::int64_t> SqliteWalk::next_by_row() {
  std::string reason;
  try {
    if (!is_at_row_ && !by_row_->step()) {
      if (left_out_ > 0) {
        told_("the index of its times lacks " + messages_text(left_out_) +
              (left_out_ == 1 ? ", which comes" : ", which come") + " after the others");
      }
      phase_ = Phase::kEnd;
      return std::nullopt;
    }
    is_at_row_ = false;
    const std::int64_t time_ns = by_row_->integer(0);
    const std::int64_t row = by_row_->integer(1);
    if (!last_row_ || row > *last_row_) {
      last_row_ = row;
      if (was_given(time_ns, row)) return std::nullopt;
      if (phase_ == Phase::kLeftOut) ++left_out_;
      return row;
    }
    reason = "its pages are not in order";
  } catch (const SqliteError& error) {
    reason = error.what();
  }
  if (!pass_damage(reason)) phase_ = Phase::kEnd;
  return std::nullopt;
}

/// Stands on the first row from `row` on, or at the end. False when that is damaged, too.
bool SqliteWalk::seek(std::int64_t row) {
  by_row_->reset();
  by_row_->bind(1, row);
  try {
    is_at_row_ = by_row_->step();
    // What a damaged tree gives instead is no way on.
    return !is_at_row_ || by_row_->integer(1) >= row;
  } catch (const SqliteError&) {
    is_at_row_ = false;
    return false;
  }
}

/// On to the first row behind the damage: in steps that grow with what is lost, and back to the
/// edge of what can be read. False when there is none.
bool SqliteWalk::pass_damage(const std::string& reason) {
  constexpr std::int64_t kStepsAtFirst = 256;
  const std::int64_t begin = last_row_ ? *last_row_ + 1 : std::numeric_limits<std::int64_t>::min();
  if (last_row_ && *last_row_ == kLastRow) return false;
  // Where nothing could be read at all, rows are looked for where rosbag2 begins to count.
  std::int64_t bad = last_row_ ? begin : 0;
  std::int64_t good = bad;
  std::int64_t lost = 0;
  while (!seek(good)) {
    bad = good;
    const std::int64_t step = 1 + lost / kStepsAtFirst;
    if (good > kLastRow - step) {
      is_at_row_ = false;
      tell_passed(reason);
      return false;
    }
    good += step;
    lost += step;
  }
  while (good - bad > 1) {
    const std::int64_t middle = bad + (good - bad) / 2;
    (seek(middle) ? good : bad) = middle;
  }
  if (!seek(good)) return false;
  tell_passed(reason);
  return is_at_row_;
}

void SqliteWalk::tell_passed(const std::string& reason) {
  if (phase_ != Phase::kByRow) return;  // told while the index was followed
  const std::int64_t before = last_row_.value_or(0);
  if (!is_at_row_) {
    told_(fmt::format("what was recorded after message {} can't be read ({})", before, reason));
  } else if (by_row_->integer(1) > before + 1) {
    told_(fmt::format("messages {} to {} can't be read ({})", before + 1, by_row_->integer(1) - 1,
                      reason));
  }
}

void SqliteWalk::lose(std::int64_t row, const std::string& reason) {
  if (lost_ > 0 && (row != last_lost_ + 1 || reason != lost_reason_)) tell_lost();
  if (lost_ == 0) first_lost_ = row;
  last_lost_ = row;
  lost_reason_ = reason;
  ++lost_;
}

void SqliteWalk::tell_lost() {
  if (lost_ == 1) told_(fmt::format("message {} can't be read ({})", first_lost_, lost_reason_));
  if (lost_ > 1) {
    told_(
        fmt::format("messages {} to {} can't be read ({})", first_lost_, last_lost_, lost_reason_));
  }
  lost_ = 0;
}

}  // namespace loopstone
