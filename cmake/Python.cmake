# The Python package: the extension module loopstone._core, its stubs and the Python sources, in the layout of the package at
# <build>/python/loopstone, so that PYTHONPATH=<build>/python tries it in place. `pip install .` installs the component `python`
# of it (pyproject.toml).

find_package(Python 3.10 REQUIRED COMPONENTS Interpreter Development.Module OPTIONAL_COMPONENTS Development.SABIModule)
if(NOT nanobind_ROOT)
  execute_process(COMMAND "${Python_EXECUTABLE}" -m nanobind --cmake_dir OUTPUT_STRIP_TRAILING_WHITESPACE
                  OUTPUT_VARIABLE nanobind_ROOT)
endif()
find_package(nanobind 3.1 REQUIRED CONFIG)

set(package "${PROJECT_BINARY_DIR}/python/loopstone")
file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/python/bindings/*.cpp")
file(GLOB modules CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/python/loopstone/*.py")
foreach(module IN LISTS modules)
  cmake_path(GET module FILENAME name)
  file(MAKE_DIRECTORY "${package}")
  file(CREATE_LINK "${module}" "${package}/${name}" SYMBOLIC)
endforeach()

nanobind_add_module(loopstone_python NB_STATIC STABLE_ABI NOMINSIZE NB_SUPPRESS_WARNINGS ${sources})
set_target_properties(loopstone_python PROPERTIES OUTPUT_NAME _core LIBRARY_OUTPUT_DIRECTORY "${package}")
# Only what an outside user has: the public headers and the library.
target_compile_options(loopstone_python PRIVATE $<TARGET_PROPERTY:loopstone_build,INTERFACE_COMPILE_OPTIONS>)
target_compile_definitions(loopstone_python PRIVATE $<TARGET_PROPERTY:loopstone_build,INTERFACE_COMPILE_DEFINITIONS>)
target_link_options(loopstone_python PRIVATE $<TARGET_PROPERTY:loopstone_build,INTERFACE_LINK_OPTIONS>)
target_include_directories(loopstone_python PRIVATE "${PROJECT_SOURCE_DIR}/python/bindings")
if(LOOPSTONE_STATIC_LIBRARIES)
  # Nobody else in the process shall see their symbols, nor they anybody's.
  include(StaticLibraries)
  target_compile_features(loopstone_python PRIVATE cxx_std_20)
  target_link_libraries(loopstone_python PRIVATE Eigen3::Eigen)
  target_include_directories(loopstone_python PRIVATE $<TARGET_PROPERTY:loopstone::loopstone,INTERFACE_INCLUDE_DIRECTORIES>)
  target_link_options(loopstone_python PRIVATE LINKER:--exclude-libs,ALL)
  loopstone_link_statically(loopstone_python)
  install(DIRECTORY "${LOOPSTONE_STATIC_LIBRARIES}/licenses" DESTINATION loopstone COMPONENT python EXCLUDE_FROM_ALL)
else()
  target_link_libraries(loopstone_python PRIVATE loopstone::loopstone)
endif()

# What type checkers and editors read of the extension; tells that the package is typed.
nanobind_add_stub(
  loopstone_python_stub
  MODULE loopstone._core
  OUTPUT "${package}/_core.pyi"
  PYTHON_PATH "${PROJECT_BINARY_DIR}/python"
  MARKER_FILE "${package}/py.typed"
  DEPENDS loopstone_python ${modules})

install(TARGETS loopstone_python LIBRARY DESTINATION loopstone COMPONENT python EXCLUDE_FROM_ALL)
install(FILES "${package}/_core.pyi" "${package}/py.typed" DESTINATION loopstone COMPONENT python EXCLUDE_FROM_ALL)
add_custom_target(loopstone_python_package DEPENDS loopstone_python_stub)
if(LOOPSTONE_INSTALLED)
  install(PROGRAMS "${LOOPSTONE_INSTALLED}/bin/loopstone" DESTINATION loopstone/bin COMPONENT python EXCLUDE_FROM_ALL)
elseif(TARGET loopstone_few_libraries)
  add_dependencies(loopstone_python_package loopstone_few_libraries)
  install(TARGETS loopstone_few_libraries RUNTIME DESTINATION loopstone/bin COMPONENT python EXCLUDE_FROM_ALL)
elseif(TARGET loopstone_program)
  add_dependencies(loopstone_python_package loopstone_program)
  install(TARGETS loopstone_program RUNTIME DESTINATION loopstone/bin COMPONENT python EXCLUDE_FROM_ALL)
endif()
