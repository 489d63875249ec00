# Test programs, found by folder. Each gtest suite becomes one ctest test (see SuiteTests.cmake).

find_package(GTest REQUIRED)
find_package(rapidcheck REQUIRED)
include(SuiteTests)

# What every test program is compiled with and linked to.
loopstone_outer_flags(loopstone_test_flags "${LOOPSTONE_TEST_FLAGS}")
add_library(loopstone_test_base INTERFACE)
# Where this is, as a header of those tests that ask: what does not ask is the same in every checkout, and ccache knows it.
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/test_headers/source_folder.hpp"
     CONTENT "#pragma once\n\n#define LOOPSTONE_SOURCE_DIR \"@PROJECT_SOURCE_DIR@\"\n" @ONLY)
target_include_directories(loopstone_test_base INTERFACE "${PROJECT_SOURCE_DIR}/tests" "${PROJECT_BINARY_DIR}/test_headers")
target_link_libraries(
  loopstone_test_base
  INTERFACE loopstone_build
            loopstone_test_flags
            loopstone::loopstone
            GTest::gtest
            GTest::gmock
            rapidcheck
            rapidcheck_gtest
            ${LOOPSTONE_LINKED_LIBRARIES}
            ${LOOPSTONE_HEADER_LIBRARIES})

# gtest's main, in a library of ours because it also carries the precompiled header of all test programs.
add_library(loopstone_test_main OBJECT "${PROJECT_SOURCE_DIR}/tests/main/main.cpp")
target_link_libraries(loopstone_test_main PRIVATE loopstone_test_base)
if(LOOPSTONE_PCH)
  target_precompile_headers(loopstone_test_main PRIVATE ${LOOPSTONE_PRECOMPILED_HEADERS} <gmock/gmock.h> <gtest/gtest.h>)
endif()

function(loopstone_test_target target)
  target_link_libraries(${target} PUBLIC loopstone_test_base)
  if(LOOPSTONE_PCH)
    target_precompile_headers(${target} REUSE_FROM loopstone_test_main)
  endif()
endfunction()

file(GLOB support_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/tests/support/*.cpp")
if(support_sources)
  add_library(loopstone_test_support STATIC ${support_sources})
  loopstone_test_target(loopstone_test_support)
endif()

set(LOOPSTONE_TEST_SUITES "" CACHE STRING "Words as Thread|Mapper: build only test sources with such a word in a suite's name")
set(LOOPSTONE_TEST_SUITES_LEFT_OUT "" CACHE STRING "Words as Realism|World: build no test source whose suites all have such a word")

# Takes out of a list of test sources those without a suite that is wanted.
function(loopstone_keep_suites list)
  if(NOT LOOPSTONE_TEST_SUITES AND NOT LOOPSTONE_TEST_SUITES_LEFT_OUT)
    return()
  endif()
  set(kept)
  foreach(source IN LISTS ${list})
    # A suite that is added to a source, or renamed, counts at once.
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
    file(READ "${source}" text)
    string(REGEX MATCHALL "(TEST|TEST_F|TEST_P|_PROP)\\([A-Za-z0-9_]+" suites "${text}")
    set(wanted "${suites}")
    list(TRANSFORM wanted REPLACE ".*\\(" "")
    if(LOOPSTONE_TEST_SUITES)
      list(FILTER wanted INCLUDE REGEX "${LOOPSTONE_TEST_SUITES}")
    endif()
    if(LOOPSTONE_TEST_SUITES_LEFT_OUT)
      list(FILTER wanted EXCLUDE REGEX "${LOOPSTONE_TEST_SUITES_LEFT_OUT}")
    endif()
    # One without a suite helps the others.
    if(wanted OR NOT suites)
      list(APPEND kept "${source}")
    endif()
  endforeach()
  set(${list} ${kept} PARENT_SCOPE)
endfunction()

set(LOOPSTONE_TESTS_LEFT_OUT "" CACHE STRING "Test programs that are not built, as test_scenario;test_localization")

# loopstone_add_tests(NAME test_grid FOLDER unit/grid LABEL unit TIMEOUT 120)
function(loopstone_add_tests)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "NAME;FOLDER;LABEL;TIMEOUT;COST" "")
  if(arg_NAME IN_LIST LOOPSTONE_TESTS_LEFT_OUT)
    return()
  endif()
  file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/tests/${arg_FOLDER}/*.cpp")
  loopstone_keep_suites(sources)
  if(NOT sources)
    return()
  endif()
  add_executable(${arg_NAME} ${sources} $<TARGET_OBJECTS:loopstone_test_main>)
  loopstone_test_target(${arg_NAME})
  if(TARGET loopstone_test_support)
    target_link_libraries(${arg_NAME} PUBLIC loopstone_test_support)
  endif()
  loopstone_discover_suites(TARGET ${arg_NAME} LABEL ${arg_LABEL} TIMEOUT ${arg_TIMEOUT} COST "${arg_COST}")
endfunction()

foreach(part IN LISTS LOOPSTONE_PARTS)
  loopstone_add_tests(NAME test_${part} FOLDER unit/${part} LABEL unit TIMEOUT 420)
endforeach()
if(NOT LOOPSTONE_LAST_PART STREQUAL "live")
  return()
endif()
loopstone_add_tests(NAME test_support FOLDER unit/support LABEL unit TIMEOUT 180)
loopstone_add_tests(NAME test_property FOLDER property LABEL property TIMEOUT 300)
loopstone_add_tests(NAME test_scenario FOLDER scenario LABEL scenario TIMEOUT 900 COST 1000)
# A laser scanner on a wire that drives through a simulated building.
add_executable(emulated_scanner "${PROJECT_SOURCE_DIR}/tests/support/programs/emulated_scanner.cpp")
target_link_libraries(emulated_scanner PRIVATE loopstone_test_base loopstone_test_support)
if(TARGET loopstone_program)
  file(GENERATE OUTPUT "${PROJECT_BINARY_DIR}/test_headers/program_paths.hpp"
       CONTENT "#pragma once\n\n#define LOOPSTONE_PROGRAM \"$<TARGET_FILE:loopstone_program>\"\n\
#define LOOPSTONE_EMULATED_SCANNER \"$<TARGET_FILE:emulated_scanner>\"\n")
  loopstone_add_tests(NAME test_cli FOLDER cli LABEL cli TIMEOUT 900 COST 500)
  if(TARGET test_cli)
    add_dependencies(test_cli loopstone_program emulated_scanner)
  endif()
endif()

# Tests that are no gtest programs.
find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)
set(check_layering "${PROJECT_SOURCE_DIR}/tests/layering/check_layering.py")
add_test(NAME layering.tree COMMAND Python3::Interpreter "${check_layering}" "${PROJECT_SOURCE_DIR}")
add_test(NAME layering.self_test COMMAND Python3::Interpreter "${check_layering}" --self-test)
set(check_function_length "${PROJECT_SOURCE_DIR}/tests/layering/check_function_length.py")
add_test(NAME layering.function_length COMMAND Python3::Interpreter "${check_function_length}" "${PROJECT_SOURCE_DIR}")
add_test(NAME layering.function_length_self_test COMMAND Python3::Interpreter "${check_function_length}" --self-test)
set(check_names "${PROJECT_SOURCE_DIR}/tests/layering/check_names.py")
add_test(NAME layering.names COMMAND Python3::Interpreter "${check_names}" "${PROJECT_SOURCE_DIR}")
add_test(NAME layering.names_self_test COMMAND Python3::Interpreter "${check_names}" --self-test)
set_tests_properties(layering.tree layering.self_test layering.function_length layering.function_length_self_test
                     PROPERTIES LABELS layering TIMEOUT 60)

set(check_docs "${PROJECT_SOURCE_DIR}/tests/docs/check_docs.py")
add_test(NAME docs.self_test COMMAND Python3::Interpreter "${check_docs}" --self-test)
set_tests_properties(docs.self_test PROPERTIES LABELS docs TIMEOUT 60)
set(check_claims "${PROJECT_SOURCE_DIR}/tests/docs/check_claims.py")
add_test(NAME docs.claims_hold COMMAND Python3::Interpreter "${check_claims}")
add_test(NAME docs.claims_self_test COMMAND Python3::Interpreter "${check_claims}" --self-test)
set_tests_properties(docs.claims_hold docs.claims_self_test PROPERTIES LABELS docs TIMEOUT 60)
set(check_tables "${PROJECT_SOURCE_DIR}/tests/docs/check_tables.py")
add_test(NAME docs.tables_are_of_this_release COMMAND Python3::Interpreter "${check_tables}")
add_test(NAME docs.tables_self_test COMMAND Python3::Interpreter "${check_tables}" --self-test)
set_tests_properties(docs.tables_are_of_this_release docs.tables_self_test PROPERTIES LABELS docs TIMEOUT 60)
# Ends with 77 where nothing can be said: without the history, or of tables that name no commit yet.
set_tests_properties(docs.tables_are_of_this_release PROPERTIES SKIP_RETURN_CODE 77)
set(check_release "${PROJECT_SOURCE_DIR}/scripts/check_release.py")
add_test(NAME docs.release COMMAND Python3::Interpreter "${check_release}" --build "${PROJECT_BINARY_DIR}")
add_test(NAME docs.release_self_test COMMAND Python3::Interpreter "${check_release}" --self-test)
set_tests_properties(docs.release docs.release_self_test PROPERTIES LABELS docs TIMEOUT 60)
if(TARGET loopstone_program)
  add_test(NAME docs.are_true COMMAND Python3::Interpreter "${check_docs}" "$<TARGET_FILE:loopstone_program>")
  set_tests_properties(docs.are_true PROPERTIES LABELS docs TIMEOUT 240)
endif()

# The program on the network, against others that speak DDS. Ends with 77 where there are none (scripts/install_ros2_peers.sh).
if(TARGET loopstone_ros2_program AND NOT LOOPSTONE_SANITIZE)
  add_test(NAME ros2.network COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/ros2/check_ros2.py"
                                     "$<TARGET_FILE:loopstone_ros2_program>" "$<TARGET_FILE:loopstone_program>")
  set_tests_properties(ros2.network PROPERTIES LABELS ros2 TIMEOUT 400 PROCESSORS 2 SKIP_RETURN_CODE 77)
endif()

# What measures the figures of docs/ is measured itself.
add_test(NAME bench.self_test COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/bench/check_bench.py")
set_tests_properties(bench.self_test PROPERTIES LABELS bench TIMEOUT 60)

# The page of the live view, where Node and Chromium are there; it is the same page in every build.
if(NOT LOOPSTONE_SANITIZE AND NOT CMAKE_CXX_FLAGS_DEBUG MATCHES "coverage")
  foreach(part unit browser)
    add_test(NAME viewer.${part} COMMAND "${PROJECT_SOURCE_DIR}/scripts/test_viewer.sh" ${part})
  endforeach()
  set_tests_properties(viewer.unit viewer.browser PROPERTIES LABELS viewer TIMEOUT 1500 SKIP_RETURN_CODE 77)
  set_tests_properties(viewer.browser PROPERTIES COST 1100) # waits more than it works; first, beside others
endif()

# An outside project; of no use with a sanitizer, whose run-time library it would have to link.
if(NOT LOOPSTONE_SANITIZE AND NOT CMAKE_CXX_FLAGS_DEBUG MATCHES "coverage")
  add_test(NAME install.outside_project COMMAND "${PROJECT_SOURCE_DIR}/tests/install/run.sh" "${CMAKE_BINARY_DIR}"
                                                ${PROJECT_VERSION})
  set_tests_properties(install.outside_project PROPERTIES LABELS install TIMEOUT 600 COST 800 ENVIRONMENT
                                                          "CXX=${CMAKE_CXX_COMPILER}")
endif()
