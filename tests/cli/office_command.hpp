#pragma once

#include <gtest/gtest.h>

#include <string>

#include "loopstone/formats/tum.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {

/// A few seconds in a simulated office: its log, its true map and the truth of every scan. Made
/// once for all tests of a suite.
class OfficeCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    log_ = *folder_ / "sim";
    const ProgramResult result = run_program({"simulate", "office", "-o", log_, "--seed", "3",
                                              "--duration", "12", "--beams", "361", "--quiet"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
    truth_ = read_tum(log_ + "/truth.tum");
    map_ = log_ + "/map.yaml";
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static inline TempDir* folder_ = nullptr;
  static inline std::string log_;
  static inline std::string map_;
  static inline Trajectory truth_;
};

}  // namespace loopstone::test
