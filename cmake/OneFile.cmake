# The program as one file that needs nothing of the machine, not even its C library: any Linux on this processor runs it.
# LOOPSTONE_STATIC_LIBRARIES is where scripts/static_libraries.sh installed what the distribution has as shared libraries alone;
# scripts/one_file.sh does all of it.

# Objects and libraries are the program's; what they are linked with is not.
add_executable(loopstone_one_file EXCLUDE_FROM_ALL $<TARGET_OBJECTS:loopstone_program>)
set_target_properties(loopstone_one_file PROPERTIES LINKER_LANGUAGE CXX OUTPUT_NAME loopstone
                                                    RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/one_file")
add_dependencies(loopstone_one_file loopstone_app loopstone)

function(static_library name)
  find_library(static_${name} NAMES lib${name}.a PATHS "${LOOPSTONE_STATIC_LIBRARIES}/lib" ${ARGN} REQUIRED)
  target_link_libraries(loopstone_one_file PRIVATE "${static_${name}}")
endfunction()
# As the linker wants them: each before those that it needs.
target_link_libraries(loopstone_one_file PRIVATE -static "$<TARGET_FILE:loopstone_app>" "$<TARGET_FILE:loopstone>")
foreach(name tbb hwy zip spdlog fmt tomlplusplus)
  static_library(${name} NO_DEFAULT_PATH)
endforeach()
foreach(name yaml-cpp png16 jpeg sqlite3 deflate zstd lz4 bz2 z)
  static_library(${name})
endforeach()
