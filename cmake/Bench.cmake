# Google Benchmark programs, bench/bench_*.cpp.

find_package(benchmark REQUIRED)
file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/bench/bench_*.cpp")
foreach(source IN LISTS sources)
  cmake_path(GET source STEM target)
  add_executable(${target} ${source})
  target_link_libraries(${target} PRIVATE loopstone_build loopstone::loopstone benchmark::benchmark benchmark::benchmark_main
                                          ${LOOPSTONE_HEADER_LIBRARIES})
  if(TARGET loopstone_test_support)
    target_link_libraries(${target} PRIVATE loopstone_test_support)
  endif()
endforeach()
