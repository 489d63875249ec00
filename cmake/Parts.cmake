# The library: one object library per part, all linked into `loopstone`.
# A part may include only itself and parts before it in this list; tests/layering/check_layering.py holds everybody to it.

set(LOOPSTONE_PARTS
    base
    geometry
    sensor
    devices
    grid
    odometry
    registration
    mapping
    graph
    slam
    localization
    evaluation
    plan
    simulation
    messages
    formats
    pipeline
    report
    live)

# To work on a lower part while a higher one does not compile: -DLOOPSTONE_LAST_PART=grid builds the parts up to grid
# and their unit tests, and nothing else.
set(LOOPSTONE_LAST_PART "live" CACHE STRING "Build the parts up to this one only")
list(FIND LOOPSTONE_PARTS "${LOOPSTONE_LAST_PART}" last)
if(last EQUAL -1)
  message(FATAL_ERROR "LOOPSTONE_LAST_PART: no part named '${LOOPSTONE_LAST_PART}' in ${LOOPSTONE_PARTS}")
endif()
math(EXPR count "${last} + 1")
list(SUBLIST LOOPSTONE_PARTS 0 ${count} LOOPSTONE_PARTS)

# Headers that nearly every source reads, parsed once. The preset tidy reads sources without them, so one that forgets an
# include of its own is found there.
set(LOOPSTONE_PRECOMPILED_HEADERS
    <Eigen/Core>
    <Eigen/Geometry>
    <algorithm>
    <atomic>
    <chrono>
    <cmath>
    <deque>
    <filesystem>
    <fmt/format.h>
    <functional>
    <map>
    <memory>
    <mutex>
    <optional>
    <set>
    <span>
    <sstream>
    <string>
    <unordered_map>
    <variant>
    <vector>)

# The page of the live view goes into the library as it was built: users need no Node.
file(GLOB LOOPSTONE_PAGE CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/viewer/built/index.html")
if(NOT LOOPSTONE_PAGE)
  set(LOOPSTONE_PAGE "${PROJECT_SOURCE_DIR}/src/live/placeholder_page.html")
endif()
set(LOOPSTONE_PAGE_SOURCE "${PROJECT_BINARY_DIR}/page.cpp")
add_custom_command(
  OUTPUT "${LOOPSTONE_PAGE_SOURCE}"
  COMMAND ${CMAKE_COMMAND} -D "PAGE=${LOOPSTONE_PAGE}" -D "SOURCE=${LOOPSTONE_PAGE_SOURCE}" -P
          "${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake"
  DEPENDS "${LOOPSTONE_PAGE}" "${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake"
  VERBATIM)

set(loopstone_objects)
foreach(part IN LISTS LOOPSTONE_PARTS)
  file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/${part}/*.cpp")
  if(part STREQUAL "live")
    list(APPEND sources "${LOOPSTONE_PAGE_SOURCE}")
  endif()
  if(sources)
    add_library(loopstone_${part}_objects OBJECT ${sources})
    target_link_libraries(loopstone_${part}_objects PRIVATE loopstone_build Eigen3::Eigen ${LOOPSTONE_LINKED_LIBRARIES}
                                                            ${LOOPSTONE_HEADER_LIBRARIES})
    # So that a static library can go into somebody's shared one.
    set_target_properties(loopstone_${part}_objects PROPERTIES POSITION_INDEPENDENT_CODE ON)
    if(LOOPSTONE_PCH)
      if(part STREQUAL "base")
        target_precompile_headers(loopstone_base_objects PRIVATE ${LOOPSTONE_PRECOMPILED_HEADERS})
      else()
        target_precompile_headers(loopstone_${part}_objects REUSE_FROM loopstone_base_objects)
      endif()
    endif()
    list(APPEND loopstone_objects $<TARGET_OBJECTS:loopstone_${part}_objects>)
  endif()
endforeach()

if(NOT loopstone_objects)
  message(FATAL_ERROR "src/ holds no sources")
endif()

add_library(loopstone ${loopstone_objects})
add_library(loopstone::loopstone ALIAS loopstone)
set_target_properties(loopstone PROPERTIES LINKER_LANGUAGE CXX VERSION ${PROJECT_VERSION}
                                           SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
target_compile_features(loopstone PUBLIC cxx_std_20)
target_include_directories(loopstone PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                                            $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(loopstone PUBLIC Eigen3::Eigen PRIVATE ${LOOPSTONE_LINKED_LIBRARIES} $<BUILD_INTERFACE:loopstone_build>)

# loopstone_outer_flags(TARGET FLAGS): what is linked to TARGET is compiled with FLAGS, unlike the library. Of a function that
# both compile (an inline one, a template) the linker keeps the copy that it meets first, so then the whole library comes first;
# else the library would run the outer copies, at -O0 several times slower.
function(loopstone_outer_flags target flags)
  add_library(${target} INTERFACE)
  if(flags)
    target_compile_options(${target} INTERFACE ${flags})
    target_link_options(${target} INTERFACE "LINKER:--whole-archive,$<TARGET_FILE:loopstone>,--no-whole-archive")
  endif()
endfunction()
