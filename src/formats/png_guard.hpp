#pragma once

#include <png.h>

#include <csetjmp>

// libpng reports errors by longjmp, which skips destructors. So every call that may jump sits in
// guarded(), whose body holds no object that would need one.

namespace loopstone {

/// What libpng says does not reach people: its words name neither file nor place.
[[noreturn]] inline void on_png_error(png_structp png, png_const_charp) { png_longjmp(png, 1); }

inline void on_png_warning(png_structp, png_const_charp) {}

/// Runs body; false when libpng jumped out of it.
template <typename Body>
bool guarded(png_structp png, const Body& body) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  body();
  return true;
}

}  // namespace loopstone
