# Third-party libraries, all packaged by Debian. Only Eigen appears in public headers.

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(hwy 1.0 REQUIRED CONFIG)
find_package(BZip2 REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(JPEG REQUIRED)
find_package(Boost 1.74 REQUIRED) # headers alone: Beast and Asio
find_package(PkgConfig REQUIRED)
pkg_check_modules(loopstone_libzip REQUIRED IMPORTED_TARGET libzip) # Debian's CMake config of libzip needs zipcmp installed
pkg_check_modules(loopstone_libdeflate REQUIRED IMPORTED_TARGET libdeflate)
pkg_check_modules(loopstone_libzstd REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(loopstone_liblz4 REQUIRED IMPORTED_TARGET liblz4)

# Libraries that end up on the link line of a program that uses a static libloopstone (see cmake/loopstone-config.cmake.in).
set(LOOPSTONE_LINKED_LIBRARIES
    Threads::Threads
    TBB::tbb
    hwy::hwy
    fmt::fmt
    tomlplusplus::tomlplusplus
    yaml-cpp
    PNG::PNG
    ZLIB::ZLIB
    BZip2::BZip2
    PkgConfig::loopstone_libzip
    PkgConfig::loopstone_libdeflate
    PkgConfig::loopstone_libzstd
    PkgConfig::loopstone_liblz4
    SQLite::SQLite3
    JPEG::JPEG)

# Header-only libraries, needed only while building.
set(LOOPSTONE_HEADER_LIBRARIES nlohmann_json::nlohmann_json Boost::headers)
