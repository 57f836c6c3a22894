# What others need to build on the libraries (find_package(vir-slam)), and the Debian packages.
# Everything is taken from the targets of vir_library and vir_component: there is no list to keep.
include(CMakePackageConfigHelpers)

set(VIR_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/vir-slam)

# The packages that linking to `target` needs, those of our libraries below it included. A target of
# another package is called after it: Ceres::ceres, but mrpt::obs of mrpt-obs and opencv_core.
function(vir_packages_of target out)
  set(found)
  get_target_property(links ${target} INTERFACE_LINK_LIBRARIES)
  if(NOT links)
    set(links)
  endif()
  foreach(link ${links})
    string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" link "${link}")
    if(link MATCHES "^vir::|^vir_")
      vir_packages_of(${link} more)
      list(APPEND found ${more})
    elseif(link MATCHES "^mrpt::(.*)$")
      list(APPEND found mrpt-${CMAKE_MATCH_1})
    elseif(link MATCHES "^opencv_(.*)$")
      list(APPEND found OpenCV)
    elseif(link MATCHES "^(.*)::")
      list(APPEND found ${CMAKE_MATCH_1})
    elseif(TARGET ${link})
      list(APPEND found ${link})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES found)
  list(SORT found)
  set(${out} ${found} PARENT_SCOPE)
endfunction()

get_property(VIR_COMPONENTS GLOBAL PROPERTY VIR_LIBRARIES)
set(VIR_COMPONENT_PACKAGES "")
set(VIR_ALL_PACKAGES)
foreach(component ${VIR_COMPONENTS})
  vir_packages_of(vir::${component} packages)
  string(APPEND VIR_COMPONENT_PACKAGES "set(_vir_packages_of_${component} ${packages})\n")
  list(APPEND VIR_ALL_PACKAGES ${packages})
endforeach()
list(REMOVE_DUPLICATES VIR_ALL_PACKAGES)

configure_package_config_file(cmake/vir-slamConfig.cmake.in ${PROJECT_BINARY_DIR}/vir-slamConfig.cmake
  INSTALL_DESTINATION ${VIR_CMAKE_DIR} PATH_VARS VIR_PLUGIN_DIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/vir-slamConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(EXPORT vir-slam NAMESPACE vir:: FILE vir-slamTargets.cmake DESTINATION ${VIR_CMAKE_DIR}
  COMPONENT dev)
install(FILES ${PROJECT_BINARY_DIR}/vir-slamConfig.cmake ${PROJECT_BINARY_DIR}/vir-slamConfigVersion.cmake
  DESTINATION ${VIR_CMAKE_DIR} COMPONENT dev)

install(DIRECTORY ini DESTINATION ${CMAKE_INSTALL_DATADIR}/vir-slam COMPONENT program)
# Settings name the sample relative to themselves. It is in no Debian package: 25 MB.
install(DIRECTORY rawlog DESTINATION ${CMAKE_INSTALL_DATADIR}/vir-slam COMPONENT sample)
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(FILES README.md CHANGELOG.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT dev)

# Debian packages: scripts/package.sh.
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/vir-slam RENAME copyright
  COMPONENT program)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libvir-slam-dev RENAME copyright
  COMPONENT dev)

# The Debian packages that hold the CMake packages which linking to us looks for.
set(VIR_DEBIAN_DEPENDS "vir-slam (= ${PROJECT_VERSION})")
find_program(DPKG_QUERY dpkg-query)
if(DPKG_QUERY)
  set(places)
  foreach(package ${VIR_ALL_PACKAGES})
    set(where ${${package}_DIR})
    if(NOT where)  # found by a module of CMake, which tells the library
      list(GET ${package}_LIBRARIES 0 where)
    endif()
    list(APPEND places ${where})
  endforeach()
  foreach(where ${places} ${VIR_LIBRARY_bz2} ${VIR_LIBRARY_lz4} ${VIR_LIBRARY_zstd} ${VIR_LIBRARY_sqlite3})
    execute_process(COMMAND ${DPKG_QUERY} -S ${where} OUTPUT_VARIABLE owner ERROR_QUIET)
    if(owner MATCHES "^([a-z0-9.+-]+)")
      list(APPEND VIR_DEBIAN_DEPENDS ${CMAKE_MATCH_1})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES VIR_DEBIAN_DEPENDS)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "the authors of vir-slam <root@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program dev)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "visual-inertial SLAM with ranges, on MRPT rawlogs
Trajectories from recordings of one camera, an IMU and ranges to radio (UWB)
anchors whose positions nobody has measured; live or from files.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME vir-slam)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
set(CPACK_COMPONENT_DEV_DESCRIPTION "visual-inertial SLAM with ranges: libraries
Headers and libraries of vir-slam, for programs and plugins of your own.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libvir-slam-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
list(JOIN VIR_DEBIAN_DEPENDS ", " CPACK_DEBIAN_DEV_PACKAGE_DEPENDS)
include(CPack)
