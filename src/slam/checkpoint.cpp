#include "loopstone/slam/checkpoint.hpp"

#include <algorithm>
#include <exception>
#include <memory>
#include <utility>

#include "loopstone/base/error.hpp"

namespace loopstone {

Checkpoint::Checkpoint(How how, SessionTerms terms)
    : how_(std::move(how)), earlier_{.terms = std::move(terms)} {}

double Checkpoint::now_s() const {
  return std::chrono::duration<double>(Clock::now() - started_).count();
}

void Checkpoint::resume(Session session, Mapper& mapper, const NextMessage& next) {
  const std::string differs = difference(session.terms, earlier_.terms);
  if (!differs.empty()) throw UsageError("is of another run: " + differs);
  try {
    mapper.restore_state(std::move(session.mapper));
  } catch (const UsageError& error) {
    throw UsageError(std::string("is damaged: ") + error.what());
  }
  while (log_.messages() < session.log.messages()) {
    const auto message = next();
    if (!message) break;
    log_.add(*message);
  }
  if (log_ != session.log) {
    throw UsageError("is of another log: its first " + std::to_string(session.log.messages()) +
                     " messages are not those that it was made of");
  }
  earlier_.wall_s = session.wall_s;
  earlier_.cpu_s = session.cpu_s;
}

void Checkpoint::after(const SensorMessage& message, Mapper& mapper) {
  log_.add(message);
  if (how_.every_s <= 0.0 || now_s() - last_s_ < how_.every_s) return;
  const bool busy =
      writing_.valid() && writing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
  if (!busy) save(mapper);
}

void Checkpoint::after_last(Mapper& mapper) {
  if (log_.messages() == 0) return;
  save(mapper);
  settle();
}

void Checkpoint::save(Mapper& mapper) {
  if (!how_.write) return;
  settle();
  last_s_ = now_s();
  auto session = std::make_unique<Session>();
  session->terms = earlier_.terms;
  session->log = log_;
  session->wall_s = earlier_.wall_s + last_s_;
  session->cpu_s = earlier_.cpu_s + (how_.cpu_seconds ? how_.cpu_seconds() : 0.0);
  // The back end gives its part when it has come so far; the disk takes its time. Neither holds up
  // the next scan.
  writing_ = std::async(std::launch::async, [&write = how_.write, session = std::move(session),
                                             state = mapper.save_state()]() mutable {
    session->mapper = state.get();
    return write(*session);
  });
  const double blocked_s = now_s() - last_s_;
  cost_.blocked_s += blocked_s;
  cost_.longest_s = std::max(cost_.longest_s, blocked_s);
}

void Checkpoint::settle() {
  if (!writing_.valid()) return;
  try {
    cost_.bytes = writing_.get();
    ++cost_.saved;
    told_ = false;
  } catch (const std::future_error&) {
    // The back end failed before it came so far; it says so itself.
  } catch (const std::exception& error) {
    if (!told_ && how_.failed) how_.failed(error.what());
    told_ = true;
  }
}

}  // namespace loopstone
