#include <gmock/gmock.h>

#include <cstdlib>

int main(int argc, char** argv) {
  // Laws draw the same cases in every run; RC_PARAMS="seed=..." in the environment draws others.
  setenv("RC_PARAMS", "seed=1", 0);  // NOLINT(concurrency-mt-unsafe): no thread has been started
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
