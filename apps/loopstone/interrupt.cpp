#include "interrupt.hpp"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "app.hpp"
#include "loopstone/formats/output_place.hpp"
#include "progress_display.hpp"

namespace loopstone::app {

namespace {

// Signals come to the process, not to an object of it.
std::atomic<int> holders{0};
std::atomic<bool> was_held{false};
std::atomic<bool> is_requested{false};
std::atomic<const char*> answer_to_first{""};
std::mutex outputs_mutex;
std::vector<UnfinishedOutput> outputs;

[[noreturn]] void end_at_once() {
  const std::scoped_lock lock(outputs_mutex);
  ProgressDisplay::clear_line();
  std::fputs(is_requested ? "loopstone: interrupted again: what was not written yet is lost\n"
                          : "loopstone: interrupted: nothing was written\n",
             stderr);
  for (const UnfinishedOutput& output : outputs) {
    remove_partial_files(output.folder, output.name);
    std::error_code ignored;
    if (output.was_made) std::filesystem::remove(output.folder, ignored);  // only when empty
  }
  ::_exit(kExitInterrupted);
}

}  // namespace

void listen_for_interrupts() {
  // A thread of its own, not a handler: what a handler may do is too little to clean up.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals] {
    while (true) {
      int signal = 0;
      if (sigwait(&signals, &signal) != 0) continue;
      // What was held is written; nothing is left to be interrupted.
      if (holders == 0 && was_held) continue;
      if (holders == 0 || is_requested.exchange(true)) end_at_once();
      ProgressDisplay::clear_line();
      std::fprintf(stderr, "loopstone: %s\n", answer_to_first.load());
    }
  }).detach();
}

bool interrupted() { return is_requested; }

void answer_interrupt(const char* answer) {
  answer_to_first = answer;
  is_requested = false;
}

HeldInterrupt::HeldInterrupt(const char* answer) {
  answer_to_first = answer;
  ++holders;
  was_held = true;
}
HeldInterrupt::~HeldInterrupt() { --holders; }

void clean_up_when_interrupted(UnfinishedOutput output) {
  const std::scoped_lock lock(outputs_mutex);
  outputs.push_back(std::move(output));
}

}  // namespace loopstone::app
