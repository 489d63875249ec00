#include "slam/back_end_worker.hpp"

#include <utility>

namespace loopstone {

BackEndWorker::BackEndWorker(const MapOptions& options, Threads threads, MapBoard& board)
    : board_(board), back_end_(options, threads) {}

void BackEndWorker::add_scan(MappedScan scan, const std::optional<KeyScan>& key) {
  auto shared = std::make_shared<const MappedScan>(std::move(scan));
  board_.add_scan(shared, key && key->starts_submap);
  waiting_.push_back({std::move(shared), key});
}

void BackEndWorker::add_submaps(std::vector<FinishedSubmap> submaps) {
  if (submaps.empty()) return;
  auto batch = std::make_shared<Batch>(Batch{std::exchange(waiting_, {}), std::move(submaps)});
  queue_.run([this, batch] {
    take(std::move(*batch));
    publish();
  });
}

void BackEndWorker::take(Batch batch) {
  for (WaitingScan& step : batch.scans) {
    if (step.key) back_end_.add_key(*step.key);
    back_end_.add_scan(std::move(step.scan));
    ++taken_;
  }
  for (FinishedSubmap& submap : batch.submaps) back_end_.add_submap(std::move(submap));
}

void BackEndWorker::publish() {
  BackEndView view;
  for (const SubmapRecord& submap : back_end_.submaps())
    view.submaps.push_back(snapshot_of(submap, view.submaps.size()));
  view.closures = back_end_.closures();
  view.scans_taken = taken_;
  board_.publish(std::move(view), back_end_.take_events());
}

std::future<MapperState> BackEndWorker::add_state(MapperState state) {
  auto promise = std::make_shared<std::promise<MapperState>>();
  auto saved = std::make_shared<MapperState>(std::move(state));
  saved->waiting = waiting_;
  queue_.run([this, promise, saved] {
    saved->back_end = back_end_.state();
    promise->set_value(std::move(*saved));
  });
  return promise->get_future();
}

void BackEndWorker::restore(BackEnd::State state, std::vector<WaitingScan> waiting) {
  back_end_.restore(std::move(state));
  waiting_ = std::move(waiting);
  publish();
  for (const WaitingScan& step : waiting_)
    board_.add_scan(step.scan, step.key && step.key->starts_submap);
}

void BackEndWorker::finish(const std::function<bool()>& goes_on) {
  auto batch = std::make_shared<Batch>(Batch{std::exchange(waiting_, {}), {}});
  queue_.run([this, batch, &goes_on] {
    take(std::move(*batch));
    back_end_.finish(goes_on);
  });
  queue_.wait();
}

}  // namespace loopstone
