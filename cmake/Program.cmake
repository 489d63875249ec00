# The command-line program, left at <build>/bin/loopstone; with LOOPSTONE_ROS2 also <build>/bin/loopstone-ros2. What both are made
# of is a library of its own.

file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/apps/loopstone/*.cpp")
list(REMOVE_ITEM sources "${PROJECT_SOURCE_DIR}/apps/loopstone/main.cpp")
if(sources)
  find_package(CLI11 REQUIRED)
  find_package(spdlog REQUIRED)
  loopstone_outer_flags(loopstone_program_flags "${LOOPSTONE_PROGRAM_FLAGS}")
  add_library(loopstone_app STATIC ${sources})
  target_include_directories(loopstone_app PUBLIC "${PROJECT_SOURCE_DIR}/apps/loopstone")
  target_link_libraries(
    loopstone_app PUBLIC loopstone_build loopstone_program_flags loopstone::loopstone CLI11::CLI11 spdlog::spdlog fmt::fmt Threads::Threads
                         tomlplusplus::tomlplusplus ${LOOPSTONE_HEADER_LIBRARIES})
  if(LOOPSTONE_PCH)
    # Without CLI/CLI.hpp: its classes have no functions of their own outside, so whoever sees it compiles all of them.
    target_precompile_headers(loopstone_app PRIVATE ${LOOPSTONE_PRECOMPILED_HEADERS} <fmt/format.h> <nlohmann/json.hpp>
                              <spdlog/spdlog.h>)
  endif()
  add_executable(loopstone_program "${PROJECT_SOURCE_DIR}/apps/loopstone/main.cpp")
  set_target_properties(loopstone_program PROPERTIES OUTPUT_NAME loopstone)
  target_link_libraries(loopstone_program PRIVATE loopstone_app)
  install(TARGETS loopstone_program RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT program)
  include(Pages)
  if(LOOPSTONE_STATIC_LIBRARIES)
    include(OneFile)
  endif()
  if(LOOPSTONE_ROS2)
    find_package(CycloneDDS 0.10 REQUIRED)
    file(GLOB ros2_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/apps/loopstone_ros2/*.cpp")
    add_executable(loopstone_ros2_program ${ros2_sources})
    set_target_properties(loopstone_ros2_program PROPERTIES OUTPUT_NAME loopstone-ros2)
    target_link_libraries(loopstone_ros2_program PRIVATE loopstone_app CycloneDDS::ddsc)
    install(TARGETS loopstone_ros2_program RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT ros2)
  endif()
endif()
