# loopstone_link_statically(TARGET): links TARGET with the library and all that it needs as static libraries, so that nothing but
# the C and C++ library is asked of the machine. LOOPSTONE_STATIC_LIBRARIES is where scripts/static_libraries.sh installed those
# that the distribution has not, or not position-independent. Given before other libraries, so that these find in them what they ask for.

function(loopstone_link_statically target)
  # As the linker wants them: each before those that it needs.
  set(archives)
  foreach(name tbb hwy zip spdlog fmt tomlplusplus yaml-cpp png16 jpeg sqlite3 deflate zstd lz4 bz2 z)
    if(name MATCHES "^(sqlite3|deflate|lz4|z)$")
      find_library(archive_of_${name} NAMES lib${name}.a REQUIRED)
    else()
      find_library(archive_of_${name} NAMES lib${name}.a PATHS "${LOOPSTONE_STATIC_LIBRARIES}/lib" NO_DEFAULT_PATH REQUIRED)
    endif()
    list(APPEND archives "${archive_of_${name}}")
  endforeach()
  target_link_libraries(${target} PRIVATE "$<TARGET_FILE:loopstone::loopstone>" ${archives} Threads::Threads)
endfunction()
