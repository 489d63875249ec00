# Google Benchmark programs, bench/bench_*.cpp, and programs that the scripts of bench/ run, bench/measure_*.cpp.

find_package(benchmark REQUIRED)

function(loopstone_bench_program source)
  cmake_path(GET source STEM target)
  add_executable(${target} ${source})
  target_link_libraries(${target} PRIVATE loopstone_build loopstone::loopstone ${LOOPSTONE_HEADER_LIBRARIES} ${ARGN})
  if(TARGET loopstone_test_support)
    target_link_libraries(${target} PRIVATE loopstone_test_support)
  endif()
endfunction()

file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/bench/bench_*.cpp")
foreach(source IN LISTS sources)
  loopstone_bench_program(${source} benchmark::benchmark benchmark::benchmark_main)
endforeach()

file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/bench/measure_*.cpp")
foreach(source IN LISTS sources)
  loopstone_bench_program(${source})
endforeach()

# The update that ours is measured against is compiled as its project compiles it.
set_source_files_properties("${PROJECT_SOURCE_DIR}/bench/bench_likelihood_field.cpp" PROPERTIES COMPILE_OPTIONS -O3)
