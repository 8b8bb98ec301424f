# SPDX-License-Identifier: MIT
set(prefix ${WORK_DIR}/install)

# Runs a command; one that fails ends the test with its output.
function(run step)
  message(STATUS "${step}")
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${step} failed (${result}):\n${output}")
  endif()
endfunction()
