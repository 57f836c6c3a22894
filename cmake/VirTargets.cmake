# One helper per kind of target, so that warnings, sanitizers and include paths are set in one place.

function(vir_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra $<$<BOOL:${VIR_WERROR}>:-Werror>)
  # Not for tests, which are full of literals of another type.
  set(tests "${PROJECT_SOURCE_DIR}/tests")
  cmake_path(IS_PREFIX tests "${CMAKE_CURRENT_SOURCE_DIR}" is_test)
  if(VIR_STRICT AND NOT is_test)
    # Of clang's conversions those between signed and unsigned are left out: gcc means them by another
    # name, and indices of containers would need a cast each.
    target_compile_options(${target} PRIVATE -Wconversion -Wshadow -Woverloaded-virtual
      $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion>)
  endif()
  if(VIR_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${VIR_SANITIZE} -fno-omit-frame-pointer
      # gcc takes the checks themselves for reads of uninitialised values.
      $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    target_link_options(${target} PRIVATE -fsanitize=${VIR_SANITIZE})
    # What is tested is optimised, the test's own lines need twice as long to be compiled so.
    if(is_test)
      target_compile_options(${target} PRIVATE -O0)
      target_compile_definitions(${target} PRIVATE VIR_SANITIZED)
    endif()
  endif()
  if(VIR_COVERAGE)
    if(NOT is_test)
      target_compile_options(${target} PRIVATE --coverage)
    endif()
    target_link_options(${target} PRIVATE --coverage)
  endif()
endfunction()

# vir_throwing_new(TARGET): for a program that reads rawlogs of others, which is to go on when memory is refused.
function(vir_throwing_new target)
  if(VIR_SANITIZE MATCHES address)
    target_sources(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/sanitized_new.cpp)
  endif()
endfunction()

# vir_library(NAME [SHARED] [SOURCES ...] [DEPENDS ...] [PRIVATE_DEPENDS ...])
# A library of libs/NAME: headers in include/vir/NAME, sources in src (none: headers only). Target:
# vir_NAME, alias vir::NAME, which is its name for others too (VirPackage.cmake).
function(vir_library name)
  cmake_parse_arguments(ARG "SHARED" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  if(NOT ARG_SOURCES)
    add_library(vir_${name} INTERFACE)
    set(scope INTERFACE)
    target_link_libraries(vir_${name} INTERFACE ${ARG_DEPENDS})
  else()
    set(kind STATIC)
    if(ARG_SHARED)
      set(kind SHARED)
    endif()
    add_library(vir_${name} ${kind} ${ARG_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(vir_${name} PUBLIC ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE_DEPENDS})
    vir_compile_options(vir_${name})
  endif()
  add_library(vir::${name} ALIAS vir_${name})
  target_compile_features(vir_${name} ${scope} cxx_std_17)
  target_include_directories(vir_${name} ${scope}
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  set_target_properties(vir_${name} PROPERTIES EXPORT_NAME ${name})
  if(ARG_SHARED)
    set_target_properties(vir_${name} PROPERTIES VERSION ${PROJECT_VERSION}
      SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  endif()
  set_property(GLOBAL APPEND PROPERTY VIR_LIBRARIES ${name})
  install(TARGETS vir_${name} EXPORT vir-slam
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT program NAMELINK_COMPONENT dev)
  install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev
    FILES_MATCHING PATTERN "*.h")
endfunction()

# vir_component(NAME LIBRARY...): a name under which others find several libraries, or one by what it
# is for. Every library is a component under its own name anyway.
function(vir_component name)
  add_library(vir_${name} INTERFACE)
  add_library(vir::${name} ALIAS vir_${name})
  list(TRANSFORM ARGN PREPEND vir::)
  target_link_libraries(vir_${name} INTERFACE ${ARGN})
  set_target_properties(vir_${name} PROPERTIES EXPORT_NAME ${name})
  set_property(GLOBAL APPEND PROPERTY VIR_LIBRARIES ${name})
  install(TARGETS vir_${name} EXPORT vir-slam)
endfunction()

# Not by GNUInstallDirs: the program looks for its plugins in ../lib/vir-slam/plugins.
set(VIR_PLUGIN_DIR lib/vir-slam/plugins)

# How something installed in `folder` finds our shared libraries, wherever the tree is moved to.
function(vir_find_libraries_from target folder)
  cmake_path(ABSOLUTE_PATH folder BASE_DIRECTORY "${CMAKE_INSTALL_PREFIX}")
  cmake_path(RELATIVE_PATH CMAKE_INSTALL_FULL_LIBDIR BASE_DIRECTORY "${folder}" OUTPUT_VARIABLE way)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/${way}")
endfunction()

# vir_plugin(NAME SOURCES ... DEPENDS ...): one shared object, found at run time in the plugin folder.
function(vir_plugin name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_library(vir_plugin_${name} MODULE ${ARG_SOURCES})
  target_link_libraries(vir_plugin_${name} PRIVATE ${ARG_DEPENDS})
  # An undefined symbol would only show when the plugin is used: refuse it at link time.
  if(NOT VIR_SANITIZE)
    target_link_options(vir_plugin_${name} PRIVATE -Wl,-z,defs)
  endif()
  set_target_properties(vir_plugin_${name} PROPERTIES
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/${VIR_PLUGIN_DIR})
  vir_find_libraries_from(vir_plugin_${name} ${VIR_PLUGIN_DIR})
  install(TARGETS vir_plugin_${name} LIBRARY DESTINATION ${VIR_PLUGIN_DIR} COMPONENT program)
  set_property(GLOBAL APPEND PROPERTY VIR_INSTALLED vir_plugin_${name})
  vir_compile_options(vir_plugin_${name})
endfunction()

# vir_module(NAME SOURCES ... DEPENDS ...): a part of the program with libraries that nobody else needs, opened
# when it is asked for; beside the folder of the plugins.
cmake_path(GET VIR_PLUGIN_DIR PARENT_PATH VIR_MODULE_DIR)
function(vir_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_library(${name} MODULE ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS})
  set_target_properties(${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/${VIR_MODULE_DIR})
  vir_find_libraries_from(${name} ${VIR_MODULE_DIR})
  install(TARGETS ${name} LIBRARY DESTINATION ${VIR_MODULE_DIR} COMPONENT program)
  set_property(GLOBAL APPEND PROPERTY VIR_INSTALLED ${name})
  vir_compile_options(${name})
endfunction()

# vir_program(NAME): installs a program, with its man pages and completion made from its --help.
function(vir_program name)
  vir_find_libraries_from(${name} ${CMAKE_INSTALL_BINDIR})
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
  set(folder ${PROJECT_BINARY_DIR}/described/${name})
  set(script ${PROJECT_SOURCE_DIR}/cmake/describe_program.sh)
  # Their settings are completed too.
  get_property(plugins GLOBAL PROPERTY VIR_INSTALLED)
  list(FILTER plugins INCLUDE REGEX "^vir_plugin_")
  add_custom_command(OUTPUT ${folder}/completions/${name} DEPENDS ${name} ${plugins} ${script}
    COMMAND ${CMAKE_COMMAND} -E env ASAN_OPTIONS=detect_leaks=0 ${script} $<TARGET_FILE:${name}> ${folder}
    COMMENT "Making man pages and completion of ${name}" VERBATIM)
  add_custom_target(describe_${name} ALL DEPENDS ${folder}/completions/${name})
  install(DIRECTORY ${folder}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
  install(DIRECTORY ${folder}/completions DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion
    COMPONENT program)
  set_property(GLOBAL APPEND PROPERTY VIR_INSTALLED ${name} describe_${name})
endfunction()

# vir_test(NAME [TOGETHER] SOURCES ... DEPENDS ... [PROPERTIES ...]): one GoogleTest executable, one ctest
# entry per case, with these properties. TOGETHER: one entry for all cases, in one process, where the cases
# share what a suite prepares or are quick against loading the libraries of MRPT and OpenCV (a quarter of a second).
function(vir_test name)
  cmake_parse_arguments(ARG "TOGETHER" "" "SOURCES;DEPENDS;PROPERTIES" ${ARGN})
  add_executable(test_${name} ${ARG_SOURCES})
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support)
  target_link_libraries(test_${name} PRIVATE ${ARG_DEPENDS} vir_test_paths vir::core GTest::gtest
                        GTest::gtest_main)
  vir_compile_options(test_${name})
  # Freed memory is kept as in the program (keepFreedMemory of its main.cpp).
  set(properties TIMEOUT 600 ENVIRONMENT
    "GLIBC_TUNABLES=glibc.malloc.mmap_threshold=33554432:glibc.malloc.trim_threshold=268435456"
    ${ARG_PROPERTIES})
  if(ARG_TOGETHER)
    add_test(NAME ${name} COMMAND test_${name})
    set_tests_properties(${name} PROPERTIES ${properties})
    return()
  endif()
  include(GoogleTest)
  gtest_discover_tests(test_${name} DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
endfunction()
