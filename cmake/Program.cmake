# The command-line program, left at <build>/bin/loopstone.

file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/apps/loopstone/*.cpp")
if(sources)
  find_package(CLI11 REQUIRED)
  find_package(spdlog REQUIRED)
  loopstone_outer_flags(loopstone_program_flags "${LOOPSTONE_PROGRAM_FLAGS}")
  add_executable(loopstone_program ${sources})
  set_target_properties(loopstone_program PROPERTIES OUTPUT_NAME loopstone)
  target_include_directories(loopstone_program PRIVATE "${PROJECT_SOURCE_DIR}/apps/loopstone")
  target_link_libraries(
    loopstone_program PRIVATE loopstone_build loopstone_program_flags loopstone::loopstone CLI11::CLI11 spdlog::spdlog fmt::fmt Threads::Threads
                              tomlplusplus::tomlplusplus ${LOOPSTONE_HEADER_LIBRARIES})
  if(LOOPSTONE_PCH)
    # Without CLI/CLI.hpp: its classes have no functions of their own outside, so whoever sees it compiles all of them.
    target_precompile_headers(loopstone_program PRIVATE ${LOOPSTONE_PRECOMPILED_HEADERS} <fmt/format.h> <nlohmann/json.hpp>
                              <spdlog/spdlog.h>)
  endif()
  install(TARGETS loopstone_program RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
endif()
