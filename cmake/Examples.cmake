# Each examples/*.cpp is a program of its own, and ctest runs it.

file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/examples/*.cpp")
foreach(source IN LISTS sources)
  cmake_path(GET source STEM stem)
  add_executable(example_${stem} ${source})
  # Only what an outside user has: the public headers and the library.
  target_compile_options(example_${stem} PRIVATE $<TARGET_PROPERTY:loopstone_build,INTERFACE_COMPILE_OPTIONS>)
  target_link_options(example_${stem} PRIVATE $<TARGET_PROPERTY:loopstone_build,INTERFACE_LINK_OPTIONS>)
  target_link_libraries(example_${stem} PRIVATE loopstone::loopstone)
  if(LOOPSTONE_TESTS)
    set(folder "${CMAKE_CURRENT_BINARY_DIR}/examples/${stem}")
    file(MAKE_DIRECTORY "${folder}")
    add_test(NAME example.${stem} COMMAND example_${stem} WORKING_DIRECTORY "${folder}")
    set_tests_properties(example.${stem} PROPERTIES LABELS example TIMEOUT 120)
  endif()
endforeach()
