# SPDX-License-Identifier: MIT
# Run when a library is installed: makes one object of ARCHIVE in which only what the sources define once is global.
#
# Templates and inline functions, ours, Eigen's and the standard library's, are weak symbols: of all copies in a program
# the linker keeps one. Compiled with -mavx2 or a sanitizer, Eigen's align and allocate differently, so a program and a
# library that do not share their flags must not share these. Here the library keeps its own.
#
# Variables: ARCHIVE, COMPILER, COMPILER_ID, NM, OBJCOPY, AR
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "sealing ${ARCHIVE} failed: ${command}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

string(REGEX REPLACE "\\.a$" ".o" object ${ARCHIVE})
set(symbols ${ARCHIVE}.weak)
set(link_time_code "")
if(COMPILER_ID STREQUAL "GNU")
  set(link_time_code -flinker-output=nolto-rel)  # machine code, if the objects hold something else
endif()
run(${COMPILER} -r -nostdlib ${link_time_code} -Wl,--force-group-allocation -Wl,--whole-archive ${ARCHIVE} -o ${object})

run(${NM} --format=posix --extern-only --defined-only ${object})
string(REGEX MATCHALL "[^ \n]+ [VWu] " weak "${output}")
list(TRANSFORM weak REPLACE " .*" "\n")
list(JOIN weak "" weak)
file(WRITE ${symbols} "${weak}")
# In two steps, as what exists once in a process (u) can be made local only when it is weak.
run(${OBJCOPY} --weaken-symbols=${symbols} ${object})
run(${OBJCOPY} --localize-symbols=${symbols} ${object})

file(REMOVE ${ARCHIVE})
run(${AR} rcs ${ARCHIVE} ${object})
file(REMOVE ${object} ${symbols})
