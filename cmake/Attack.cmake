# Spoiled files against every reader and the program, as ctest tests. `make attack` tries many more.

add_executable(attack_planted "${PROJECT_SOURCE_DIR}/tests/attack/planted_target.cpp" $<TARGET_OBJECTS:attack_server>)
target_link_libraries(attack_planted PRIVATE loopstone_build)
if(LOOPSTONE_FUZZ)
  target_link_options(attack_planted PRIVATE -fsanitize=fuzzer)
else()
  target_sources(attack_planted PRIVATE "${PROJECT_SOURCE_DIR}/fuzz/standalone_main.cpp")
endif()

# A sanitizer makes a process start ten times slower.
set(attack_arguments --programs "${CMAKE_RUNTIME_OUTPUT_DIRECTORY}" --out "${CMAKE_BINARY_DIR}/attack" --jobs 2 --inputs)
if(LOOPSTONE_SANITIZE)
  list(APPEND attack_arguments 100 --sanitizer)
else()
  list(APPEND attack_arguments 500)
endif()
add_test(NAME attack.self_test COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/attack/self_test.py"
                                       "${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
add_test(NAME attack.inputs COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/attack/attack.py" ${attack_arguments})
set_tests_properties(attack.self_test PROPERTIES LABELS attack TIMEOUT 300)
set_tests_properties(attack.inputs PROPERTIES LABELS attack TIMEOUT 900 PROCESSORS 2)
