#pragma once

#include <png.h>

#include <csetjmp>
#include <cstddef>

// libpng reports errors by longjmp, which skips destructors. So every call that may jump sits in guarded(), whose body
// holds no object that would need one.

namespace loopstone {

/// Why libpng gave up.
struct PngFailure {
  char reason[160] = "";
};

[[noreturn]] inline void on_png_error(png_structp png, png_const_charp message) {
  auto* failure = static_cast<PngFailure*>(png_get_error_ptr(png));
  std::size_t i = 0;
  for (; message[i] != '\0' && i + 1 < sizeof failure->reason; ++i) failure->reason[i] = message[i];
  failure->reason[i] = '\0';
  png_longjmp(png, 1);
}

inline void on_png_warning(png_structp, png_const_charp) {}

/// Runs body; false when libpng jumped out of it.
template <typename Body>
bool guarded(png_structp png, const Body& body) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  body();
  return true;
}

}  // namespace loopstone
