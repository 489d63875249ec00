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

# A script that uses the program.
if(LOOPSTONE_TESTS AND TARGET loopstone_program)
  add_test(NAME example.two_floors COMMAND "${PROJECT_SOURCE_DIR}/tests/examples/check_two_floors.sh"
                                           "$<TARGET_FILE:loopstone_program>" "${CMAKE_CURRENT_BINARY_DIR}/examples/two_floors")
  set_tests_properties(example.two_floors PROPERTIES LABELS example TIMEOUT 300)
endif()

# A page that shows lines of an example and what it prints.
if(LOOPSTONE_TESTS)
  find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)
  add_test(NAME docs.bayes_filters COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/scripts/bayes_filters_docs.py"
                                           "$<TARGET_FILE:example_08_bayes_filters>" --check)
  set_tests_properties(docs.bayes_filters PROPERTIES LABELS docs TIMEOUT 60)
endif()
