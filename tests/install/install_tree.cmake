# cmake --install into an empty folder: what was installed there before could hide what is missing.
file(REMOVE_RECURSE ${TO})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${FROM} --prefix ${TO} OUTPUT_QUIET
  RESULT_VARIABLE code)
if(code)
  message(FATAL_ERROR "cmake --install ${FROM} ended with ${code}")
endif()
