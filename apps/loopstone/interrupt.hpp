#pragma once

#include <string>

// Ctrl-C (SIGINT, SIGTERM). While a command only reads and computes it ends the process at once,
// with exit code 130: there is nothing to be saved, and nothing half written that could stay. Where
// results are at stake, HeldInterrupt makes the first one a question, which the work answers at its
// next step by writing what there is; the second one ends the process even there.

namespace loopstone::app {

/// Starts to listen. Before any other thread is there.
void listen_for_interrupts();

/// Ctrl-C was pressed while it was held.
[[nodiscard]] bool interrupted();

/// The first Ctrl-C was what the user ends a command by that would never end: it is answered, and
/// the next one is the first again.
/// \param answer  what is said to that; there for ever
void answer_interrupt(const char* answer);

/// While one lives, the first Ctrl-C is told by interrupted() instead of ending the process. When
/// the last one is gone the results are written: a Ctrl-C then comes too late to change anything.
class HeldInterrupt {
 public:
  /// \param answer  what is said to the first Ctrl-C; there for ever
  explicit HeldInterrupt(
      const char* answer = "interrupted: writing what there is; once more ends it at once");
  ~HeldInterrupt();
  HeldInterrupt(const HeldInterrupt&) = delete;
  HeldInterrupt& operator=(const HeldInterrupt&) = delete;
};

/// What is removed when the process is ended: what it began and did not complete.
struct UnfinishedOutput {
  std::string folder;
  std::string name;       ///< of a file in it; empty: any
  bool was_made = false;  ///< the folder, by this run: it goes, too, when it is empty
};
void clean_up_when_interrupted(UnfinishedOutput output);

}  // namespace loopstone::app
