# Each fuzz/fuzz_<name>.cpp defines LLVMFuzzerTestOneInput; its seeds lie in fuzz/corpus/<name>/.
# With LOOPSTONE_FUZZ it becomes a libFuzzer program. Otherwise a small main replays the seeds as a ctest test.

file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/fuzz/fuzz_*.cpp")
foreach(source IN LISTS sources)
  cmake_path(GET source STEM target)
  string(REGEX REPLACE "^fuzz_" "" name "${target}")
  add_executable(${target} ${source})
  target_link_libraries(${target} PRIVATE loopstone_build loopstone::loopstone ${LOOPSTONE_HEADER_LIBRARIES})
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/fuzz")
  if(LOOPSTONE_FUZZ)
    target_link_options(${target} PRIVATE -fsanitize=fuzzer)
  else()
    target_sources(${target} PRIVATE "${PROJECT_SOURCE_DIR}/fuzz/standalone_main.cpp")
    add_test(NAME fuzz_replay.${name} COMMAND ${target} "${PROJECT_SOURCE_DIR}/fuzz/corpus/${name}")
    set_tests_properties(fuzz_replay.${name} PROPERTIES LABELS fuzz TIMEOUT 120)
  endif()
endforeach()
