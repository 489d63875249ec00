# 64-bit ARM from another processor: Debian's cross compiler, the libraries of a sysroot that scripts/arm.sh makes, and qemu to
# run what was built. LOOPSTONE_SYSROOT names another sysroot.

set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)

list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES LOOPSTONE_SYSROOT)
set(LOOPSTONE_SYSROOT "${CMAKE_CURRENT_LIST_DIR}/../../build/arm/sysroot" CACHE PATH "Root folder with Debian's packages for arm64")
cmake_path(NORMAL_PATH LOOPSTONE_SYSROOT)
set(CMAKE_SYSROOT "${LOOPSTONE_SYSROOT}")

# Libraries and headers of this machine are of no use; its programs are.
set(CMAKE_FIND_ROOT_PATH "${LOOPSTONE_SYSROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_PATH} "")
set(ENV{PKG_CONFIG_SYSROOT_DIR} "${LOOPSTONE_SYSROOT}")
set(ENV{PKG_CONFIG_LIBDIR}
    "${LOOPSTONE_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${LOOPSTONE_SYSROOT}/usr/lib/pkgconfig:${LOOPSTONE_SYSROOT}/usr/share/pkgconfig")

set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -L "${LOOPSTONE_SYSROOT}")
