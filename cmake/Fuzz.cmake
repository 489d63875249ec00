# Each fuzz/fuzz_<name>.cpp defines LLVMFuzzerTestOneInput; its seeds lie in fuzz/corpus/<name>/.
# With LOOPSTONE_FUZZ it becomes a libFuzzer program, for which the parts that parse are built with its counters.
# Otherwise a small main replays the seeds. Either way a ctest test replays them.

if(LOOPSTONE_FUZZ)
  # What -fsanitize=fuzzer-no-link asks for, but in words that agree with a precompiled header built without it.
  foreach(part IN ITEMS devices messages formats live)
    target_compile_options(loopstone_${part}_objects
                           PRIVATE -fsanitize-coverage=inline-8bit-counters,indirect-calls,trace-cmp,pc-table)
  endforeach()
endif()

# Every target can be attacked, too (tests/attack/attack.py): this is the end that tries an input under limits.
add_library(attack_server OBJECT "${PROJECT_SOURCE_DIR}/tests/attack/attack_server.cpp")
target_link_libraries(attack_server PRIVATE loopstone_build)

set(fuzz_targets)
file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/fuzz/fuzz_*.cpp")
foreach(source IN LISTS sources)
  cmake_path(GET source STEM target)
  string(REGEX REPLACE "^fuzz_" "" name "${target}")
  list(APPEND fuzz_targets ${target})
  add_executable(${target} ${source} $<TARGET_OBJECTS:attack_server>)
  target_link_libraries(${target} PRIVATE loopstone_build loopstone::loopstone ${LOOPSTONE_HEADER_LIBRARIES})
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/fuzz" "${PROJECT_SOURCE_DIR}/tests")
  if(LOOPSTONE_FUZZ)
    target_link_options(${target} PRIVATE -fsanitize=fuzzer)
    set(replay -runs=0)
  else()
    target_sources(${target} PRIVATE "${PROJECT_SOURCE_DIR}/fuzz/standalone_main.cpp")
    set(replay)
  endif()
  if(LOOPSTONE_TESTS)
    add_test(NAME fuzz_replay.${name} COMMAND ${target} ${replay} "${PROJECT_SOURCE_DIR}/fuzz/corpus/${name}")
    set_tests_properties(fuzz_replay.${name} PROPERTIES LABELS fuzz TIMEOUT 120)
  endif()
endforeach()

if(LOOPSTONE_TESTS AND TARGET loopstone_program)
  include(Attack)
endif()
