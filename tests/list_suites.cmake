# SPDX-License-Identifier: MIT
# Runs after a test program is linked: writes OUTPUT, which registers each suite of PROGRAM as one test called PREFIX.SUITE. An
# EMULATOR runs programs for another processor.
# A test for each function would start a process for each, which costs more than most of them compute.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND ${EMULATOR} ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed RESULT_VARIABLE code)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests: ${code}\n${listed}")
endif()
string(REGEX MATCHALL "(^|\n)[A-Za-z0-9_/]+\\.( |\n)" suites "${listed}")
# The end of what a suite prints that has skipped tests, and none that failed.
set(skipped "tests?, listed below:\n(\\[  SKIPPED \\] [^\n]*\n)+$")
set(text "")
set(command "")
foreach(word IN LISTS EMULATOR PROGRAM)
  string(APPEND command " [[${word}]]")
endforeach()
foreach(line IN LISTS suites)
  string(REGEX REPLACE "[^A-Za-z0-9_/]" "" suite ${line})
  set(labels ${LABEL})
  set(cost "")
  if(suite IN_LIST SLOW)
    list(APPEND labels slow)
    set(cost " COST 30")  # so that they start first
    list(REMOVE_ITEM SLOW ${suite})
  endif()
  string(APPEND text "add_test([[${PREFIX}.${suite}]]${command} [[--gtest_filter=${suite}.*]])\n"
                     "set_tests_properties([[${PREFIX}.${suite}]] PROPERTIES LABELS \"${labels}\" TIMEOUT 1500${cost}\n"
                     "                     SKIP_REGULAR_EXPRESSION [[${skipped}]])\n")
endforeach()
if(SLOW)
  message(FATAL_ERROR "${PROGRAM} has no suites ${SLOW}, which its CMakeLists.txt calls slow")
endif()
if(text STREQUAL "")
  message(FATAL_ERROR "${PROGRAM} has no tests")
endif()
file(WRITE ${OUTPUT} "${text}")
