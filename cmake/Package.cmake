# Debian packages by CPack (scripts/package.sh): loopstone, the program; libloopstone-dev, the library; loopstone-ros2 where it is
# built.

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME loopstone)
set(CPACK_PACKAGE_VENDOR "Loopstone")
set(CPACK_PACKAGE_CONTACT "Loopstone developers <loopstone@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY "${PROJECT_BINARY_DIR}/packages")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME loopstone)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
    "2D LiDAR SLAM without ROS and without tuning: turns what a wheeled robot
recorded (laser scans, wheel encoders, gyro, RGB-D) into a trajectory, maps
and a report that says how far to trust them; maps live, and tells where a
robot is on a map. Reads MCAP, ROS bags, CARMEN logs and more.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libloopstone-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "libeigen3-dev, libtbb-dev, libhwy-dev, libfmt-dev, libtomlplusplus-dev, libyaml-cpp-dev, libpng-dev, libjpeg-dev, libzip-dev, zlib1g-dev, libdeflate-dev, libbz2-dev, libzstd-dev, liblz4-dev, libsqlite3-dev, pkg-config"
)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
    "Library of the Loopstone SLAM program, to be linked statically: registration,
mapping, loop closing, pose graphs, localisation, log formats, simulation.
For CMake: find_package(loopstone); for others: pkg-config loopstone.")

set(documented program:loopstone development:libloopstone-dev)
if(LOOPSTONE_ROS2)
  list(APPEND CPACK_COMPONENTS_ALL ros2)
  list(APPEND documented ros2:loopstone-ros2)
  set(CPACK_DEBIAN_ROS2_PACKAGE_NAME loopstone-ros2)
  set(CPACK_DEBIAN_ROS2_PACKAGE_SHLIBDEPS ON)
  set(CPACK_COMPONENT_ROS2_DESCRIPTION
      "Loopstone on the wire of ROS 2, by DDS: maps or localises by the scans,
odometry and tf that a robot publishes, and publishes map, tf, pose and
diagnostics. Needs no ROS 2 on this machine.")
endif()

install(FILES "${PROJECT_SOURCE_DIR}/CHANGELOG.md" DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/loopstone" COMPONENT program)
foreach(component IN LISTS documented)
  string(REPLACE ":" ";" pair "${component}")
  list(GET pair 0 name)
  list(GET pair 1 package)
  install(FILES "${PROJECT_SOURCE_DIR}/cmake/debian_copyright" DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/${package}"
          RENAME copyright COMPONENT ${name})
endforeach()

# Of this machine's packages; scripts/package.sh writes it.
install(FILES "${PROJECT_BINARY_DIR}/loopstone.spdx.json" DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/loopstone" COMPONENT program
        EXCLUDE_FROM_ALL OPTIONAL)

include(CPack)
