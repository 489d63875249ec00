# The program linked with static libraries (LOOPSTONE_STATIC_LIBRARIES), in two ways: as one file that needs nothing of the
# machine, not even its C library, so that any Linux on this processor runs it (scripts/one_file.sh); and as one that asks for the C
# and C++ library alone, and looks hosts up as the machine does, for the wheel (scripts/test_python.sh).

include(StaticLibraries)
foreach(name one_file few_libraries)
  # The objects are the program's; what they are linked with is not.
  add_executable(loopstone_${name} EXCLUDE_FROM_ALL $<TARGET_OBJECTS:loopstone_program>)
  set_target_properties(loopstone_${name} PROPERTIES LINKER_LANGUAGE CXX OUTPUT_NAME loopstone
                                                     RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/${name}")
  add_dependencies(loopstone_${name} loopstone_app loopstone)
  target_link_libraries(loopstone_${name} PRIVATE "$<TARGET_FILE:loopstone_app>")
  loopstone_link_statically(loopstone_${name})
endforeach()
target_link_options(loopstone_one_file PRIVATE -static)
target_link_options(loopstone_few_libraries PRIVATE LINKER:--strip-all)
