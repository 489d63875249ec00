#include "slam/back_end_worker.hpp"

#include <utility>

namespace loopstone {

namespace {

/// Raised whenever a field list of the back end's changes.
constexpr std::uint16_t kBackEndVersion = 3;

}  // namespace

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
  for (Step& step : batch.steps) {
    if (step.key) back_end_.add_key(*step.key);
    scans_.add(std::move(step.scan), step.key && step.key->starts_submap);
  }
  for (FinishedSubmap& submap : batch.submaps) back_end_.add_submap(std::move(submap));
  for (const std::size_t stretch : back_end_.take_thinned()) scans_.thin(stretch);
}

void BackEndWorker::publish() {
  BackEndView view;
  const auto poses = back_end_.map_T_submap();
  view.map_T_submap.assign(poses.begin(), poses.end());
  for (std::size_t i = 0; i < poses.size(); ++i) view.states.push_back(back_end_.state_of({i}));
  view.scans = scans_.share();
  view.closures = back_end_.closures();
  view.scans_taken = scans_.added();
  board_.publish(std::move(view), back_end_.take_events());
}

std::future<std::vector<StateChunk>> BackEndWorker::add_state(std::vector<StateChunk> chunks) {
  auto promise = std::make_shared<std::promise<std::vector<StateChunk>>>();
  auto saved = std::make_shared<std::vector<StateChunk>>(std::move(chunks));
  saved->push_back(save_chunk("WAIT", kBackEndVersion, waiting_));
  queue_.run([this, promise, saved] {
    saved->push_back(save_chunk("BACK", kBackEndVersion, back_end_));
    saved->push_back(save_chunk("MAPD", kBackEndVersion, scans_));
    promise->set_value(std::move(*saved));
  });
  return promise->get_future();
}

void BackEndWorker::restore(std::span<const StateChunk> chunks) {
  load_chunk(chunks, "WAIT", kBackEndVersion, waiting_);
  load_chunk(chunks, "BACK", kBackEndVersion, back_end_);
  load_chunk(chunks, "MAPD", kBackEndVersion, scans_);
}

bool BackEndWorker::scans_fit(std::size_t scans) const {
  if (scans_.stretch_count() != back_end_.stretch_count()) return false;
  const std::vector<KeyScan> keys = back_end_.keys();
  std::size_t key = 0;
  std::optional<std::size_t> last;
  bool fits = true;
  const auto take = [&](const MappedScan& mapped, bool is_key) {
    fits =
        fits && mapped.index < scans && (!last || mapped.index > *last) && mapped.is_key == is_key;
    last = mapped.index;
  };
  scans_.for_each([&](const MappedScan& mapped) {
    const bool is_key = key < keys.size() && keys[key].scan == mapped.index;
    take(mapped, is_key);
    if (is_key) ++key;
  });
  for (const Step& step : waiting_) {
    take(*step.scan, step.key.has_value());
    fits = fits && (!step.key || step.key->scan == step.scan->index);
  }
  return fits && key == keys.size();
}

void BackEndWorker::show_restored() {
  publish();
  for (const Step& step : waiting_) board_.add_scan(step.scan, step.key && step.key->starts_submap);
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
