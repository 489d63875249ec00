# loopstone_discover_suites(TARGET t LABEL l TIMEOUT seconds [COST c])
#
# Registers every gtest suite of a program as one ctest test, named <target>.<Suite>. Finer than one test per program,
# so ctest runs suites in parallel; coarser than one per TEST, so that SetUpTestSuite (a simulated world, a map) runs once
# and hundreds of laws do not cost hundreds of process starts. The suites are listed when ctest starts, not when building.
function(loopstone_discover_suites)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "TARGET;LABEL;TIMEOUT;COST" "")
  if(LOOPSTONE_SANITIZE)
    math(EXPR arg_TIMEOUT "${arg_TIMEOUT} * 4")
  endif()
  set(script "${CMAKE_CURRENT_BINARY_DIR}/ctest/${arg_TARGET}.cmake")
  file(
    GENERATE
    OUTPUT "${script}"
    CONTENT "set(program \"$<TARGET_FILE:${arg_TARGET}>\")
set(emulator \"${CMAKE_CROSSCOMPILING_EMULATOR}\")
set(target \"${arg_TARGET}\")
set(label \"${arg_LABEL}\")
set(timeout \"${arg_TIMEOUT}\")
set(cost \"${arg_COST}\")
set(working_directory \"${PROJECT_SOURCE_DIR}\")
include(\"${PROJECT_SOURCE_DIR}/cmake/ListSuites.cmake\")
")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES "${script}")
endfunction()
