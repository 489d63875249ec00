# Manual pages and what shells complete, made of the program's own --help.

find_package(Python3 3.9 COMPONENTS Interpreter)
if(NOT Python3_FOUND OR CMAKE_CROSSCOMPILING OR LOOPSTONE_SANITIZE)
  return()
endif()

set(pages "${PROJECT_BINARY_DIR}/pages")
file(GLOB page_scripts CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/scripts/program_help.py" "${PROJECT_SOURCE_DIR}/scripts/write_pages.py")
add_custom_command(
  OUTPUT "${pages}/made"
  COMMAND Python3::Interpreter -B "${PROJECT_SOURCE_DIR}/scripts/write_pages.py" "$<TARGET_FILE:loopstone_program>" "${pages}"
  COMMAND ${CMAKE_COMMAND} -E touch "${pages}/made"
  DEPENDS loopstone_program ${page_scripts}
  COMMENT "Writing manual pages"
  VERBATIM)
add_custom_target(loopstone_pages ALL DEPENDS "${pages}/made")

# Where each looks by itself. What packages bring to zsh Debian keeps apart from what an owner installs.
set(data "${CMAKE_INSTALL_DATADIR}")
install(DIRECTORY "${pages}/man1" DESTINATION "${CMAKE_INSTALL_MANDIR}" COMPONENT program)
install(FILES "${pages}/bash/loopstone" DESTINATION "${data}/bash-completion/completions" COMPONENT program)
install(FILES "${pages}/fish/loopstone.fish" DESTINATION "${data}/fish/vendor_completions.d" COMPONENT program)
install(FILES "${pages}/zsh/_loopstone" DESTINATION "${data}/zsh/site-functions" COMPONENT local)
install(FILES "${pages}/zsh/_loopstone" DESTINATION "${data}/zsh/vendor-completions" COMPONENT program EXCLUDE_FROM_ALL)

if(LOOPSTONE_TESTS)
  add_test(NAME packages.pages COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/packages/check_pages.py"
                                       "$<TARGET_FILE:loopstone_program>")
  set_tests_properties(packages.pages PROPERTIES LABELS packages TIMEOUT 120)
endif()
