#pragma once

#include "support/segment_world.hpp"

namespace loopstone::test {

/// A corridor around a block, with cabinets, so that the robot comes back to where it was by a way
/// of its own.
inline Walls ring() {
  return together({rectangle({0.0, 0.0}, {14.0, 10.0}), rectangle({3.0, 3.0}, {11.0, 7.0}),
                   rectangle({5.0, 0.0}, {6.1, 0.5}), rectangle({8.5, 2.6}, {9.0, 3.0}),
                   rectangle({13.3, 4.0}, {14.0, 4.9}), rectangle({11.0, 5.8}, {11.4, 6.4}),
                   rectangle({7.0, 9.4}, {8.6, 10.0}), rectangle({4.0, 7.0}, {4.3, 7.6}),
                   rectangle({0.0, 6.0}, {0.5, 6.7}), rectangle({2.5, 4.0}, {3.0, 4.4})});
}

}  // namespace loopstone::test
