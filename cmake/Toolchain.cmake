# How every target of this project is compiled: the interface target `loopstone_build`.

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
  set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/lib")
  set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/lib")
endif()
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

find_program(LOOPSTONE_CCACHE ccache)
if(LOOPSTONE_CCACHE AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  # The sloppiness lets ccache keep objects that were built with a precompiled header. The folder makes paths within it
  # relative: GCC never writes the same precompiled header twice, so a checkout that does not find it in the cache finds
  # nothing else there.
  set(CMAKE_CXX_COMPILER_LAUNCHER
      ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
      "CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}" ${LOOPSTONE_CCACHE})
endif()

add_library(loopstone_build INTERFACE)
target_compile_features(loopstone_build INTERFACE cxx_std_20)
set(CMAKE_CXX_EXTENSIONS OFF)
target_compile_definitions(loopstone_build INTERFACE EIGEN_MPL2_ONLY)
target_include_directories(loopstone_build INTERFACE "${PROJECT_SOURCE_DIR}/include" "${PROJECT_SOURCE_DIR}/src")

# Fused multiply-add rounds once where a * b + c rounds twice. Whether a compiler fuses depends on its version, its
# inlining and the processor it builds for, so with contraction the same log could give two maps. Off, everywhere.
# For the same reason there is no -ffast-math and no -march=native here.
target_compile_options(loopstone_build INTERFACE -ffp-contract=off)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
  # Eigen fuses by name.
  target_include_directories(loopstone_build BEFORE INTERFACE "${PROJECT_SOURCE_DIR}/cmake/toolchains/unfused")
endif()

if(LOOPSTONE_PCH AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(loopstone_build INTERFACE -fpch-preprocess) # ccache asks for it
endif()

target_compile_options(
  loopstone_build
  INTERFACE -Wall
            -Wextra
            -Wpedantic
            -Wshadow
            -Wnon-virtual-dtor
            -Woverloaded-virtual
            -Wcast-align
            -Wextra-semi
            -Wfloat-conversion
            -Wimplicit-fallthrough
            # {.max_range_m = 8.0} leaves the other members at their defaults on purpose.
            -Wno-missing-field-initializers
            # GCC 12 reports both inside Eigen's fixed-size matrices at -O2 and under the sanitizers, wrongly.
            $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized
            -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread -Wno-restrict>)
if(LOOPSTONE_WERROR)
  target_compile_options(loopstone_build INTERFACE -Werror)
endif()

if(LOOPSTONE_SANITIZE)
  target_compile_options(loopstone_build INTERFACE -fsanitize=${LOOPSTONE_SANITIZE} -fno-omit-frame-pointer
                                                   -fno-sanitize-recover=all)
  target_link_options(loopstone_build INTERFACE -fsanitize=${LOOPSTONE_SANITIZE})
  if(LOOPSTONE_SANITIZE MATCHES "undefined" AND CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    # Casts of numbers that no integer holds; not part of "undefined".
    target_compile_options(loopstone_build INTERFACE -fsanitize=float-cast-overflow)
    target_link_options(loopstone_build INTERFACE -fsanitize=float-cast-overflow)
    # Third-party libraries without type information make this one check fire at their borders.
    target_compile_options(loopstone_build INTERFACE -fno-sanitize=vptr)
    if(LOOPSTONE_SANITIZE_QUICK)
      # They stand before every access: half of the time to compile.
      target_compile_options(
        loopstone_build INTERFACE -fno-sanitize=null,alignment,object-size,nonnull-attribute,returns-nonnull-attribute,pointer-overflow)
    endif()
  endif()
endif()

# lld links the many test programs several times faster than bfd; gold and bfd remain the fallback.
find_program(LOOPSTONE_LLD ld.lld)
if(LOOPSTONE_LLD AND NOT CMAKE_CROSSCOMPILING) # a cross compiler asks for one of its own name
  target_link_options(loopstone_build INTERFACE -fuse-ld=lld)
endif()
