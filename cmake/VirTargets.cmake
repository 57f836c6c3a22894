# One helper per kind of target, so that warnings, sanitizers and include paths are set in one place.

function(vir_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra $<$<BOOL:${VIR_WERROR}>:-Werror>)
  if(VIR_STRICT)
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
  endif()
endfunction()

# vir_library(NAME [SHARED] SOURCES ... [DEPENDS ...] [PRIVATE_DEPENDS ...])
# A library of libs/NAME: headers in include/vir/NAME, sources in src. Target: vir_NAME, alias vir::NAME.
function(vir_library name)
  cmake_parse_arguments(ARG "SHARED" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  set(kind STATIC)
  if(ARG_SHARED)
    set(kind SHARED)
  endif()
  add_library(vir_${name} ${kind} ${ARG_SOURCES})
  add_library(vir::${name} ALIAS vir_${name})
  target_include_directories(vir_${name} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include)
  target_link_libraries(vir_${name} PUBLIC ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE_DEPENDS})
  vir_compile_options(vir_${name})
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
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib/vir-slam/plugins
    INSTALL_RPATH "$ORIGIN/../..")
  install(TARGETS vir_plugin_${name} LIBRARY DESTINATION lib/vir-slam/plugins)
  vir_compile_options(vir_plugin_${name})
endfunction()

# vir_test(NAME SOURCES ... DEPENDS ...): one GoogleTest executable, one ctest entry per case.
function(vir_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(test_${name} ${ARG_SOURCES})
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support)
  target_link_libraries(test_${name} PRIVATE ${ARG_DEPENDS} GTest::gtest GTest::gtest_main)
  target_compile_definitions(test_${name} PRIVATE
    VIR_SOURCE_DIR="${PROJECT_SOURCE_DIR}" VIR_BINARY_DIR="${PROJECT_BINARY_DIR}")
  vir_compile_options(test_${name})
  include(GoogleTest)
  gtest_discover_tests(test_${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600)
endfunction()
