# SPDX-License-Identifier: MIT
# Run by ctest: configures, builds and runs the projects beside this file and the example of the documentation against
# what install.cmake installed. Any step that fails ends the test with that step's output.
#
# WAY says how the projects are compiled:
#   plain      like the library
#   haswell    for a processor with AVX2, with which Eigen aligns and allocates differently
#   sanitized  with AddressSanitizer, with which Eigen allocates differently, and for that processor if this is one
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)

set(haswell_works FALSE)
if(NOT WAY STREQUAL "plain")
  file(WRITE ${WORK_DIR}/${WAY}/probe.cc
       "int main() { return __builtin_cpu_supports(\"avx2\") && __builtin_cpu_supports(\"fma\") ? 0 : 1; }\n")
  execute_process(COMMAND ${CXX_COMPILER} -march=haswell ${WORK_DIR}/${WAY}/probe.cc -o ${WORK_DIR}/${WAY}/probe
                  RESULT_VARIABLE result OUTPUT_QUIET ERROR_QUIET)
  if(result EQUAL 0)
    execute_process(COMMAND ${WORK_DIR}/${WAY}/probe RESULT_VARIABLE result)
  endif()
  if(result EQUAL 0)
    set(haswell_works TRUE)
  endif()
endif()

set(build_type "${CONFIG}")
if(WAY STREQUAL "haswell")
  if(NOT haswell_works)
    message("SKIPPED: this compiler or processor has no -march=haswell")
    return()
  endif()
  string(APPEND CXX_FLAGS " -march=haswell")
elseif(WAY STREQUAL "sanitized")
  # Hardly optimised, so that functions are called that are inlined otherwise.
  set(build_type "None")
  string(APPEND CXX_FLAGS " -O1 -fsanitize=address")
  if(haswell_works)
    string(APPEND CXX_FLAGS " -march=haswell")
  else()
    message(STATUS "without -march=haswell, which this compiler or processor does not have")
  endif()
endif()
if(SANITIZE)
  string(APPEND CXX_FLAGS " -fsanitize=${SANITIZE} -fno-sanitize-recover=all")
endif()
# A list as one argument: its semicolons must survive the list of arguments that it becomes a part of.
string(JOIN "\\;" prefix_path ${prefix} ${PREFIX_PATH})
# All projects are compiled like the library, and those that hold values of Eigen in one of the other two ways.
set(projects_plain camera_only files_only everything front_doors readme)
set(projects_haswell camera_only files_only)
set(projects_sanitized everything)
set(examples_plain test_harness rig)
set(examples_haswell test_harness rig)
set(examples_sanitized)
set(sources)
foreach(project IN LISTS projects_${WAY})
  list(APPEND sources ${CMAKE_CURRENT_LIST_DIR}/${project})
endforeach()
foreach(example IN LISTS examples_${WAY})
  list(APPEND sources ${SOURCE_DIR}/docs/examples/${example})
endforeach()
if(NOT sources)
  message(FATAL_ERROR "WAY is '${WAY}'; expected plain, haswell or sanitized")
endif()
foreach(source IN LISTS sources)
  get_filename_component(project ${source} NAME)
  set(dir ${WORK_DIR}/${WAY}/${project})
  set(type "${build_type}")
  if(project MATCHES "^(front_doors|readme)$")
    set(type None)  # many short examples, which compute little
  endif()
  file(REMOVE_RECURSE ${dir})
  run("configure ${project}" ${CMAKE_COMMAND} -S ${source} -B ${dir} -G "${GENERATOR}"
      -DCMAKE_PREFIX_PATH=${prefix_path} -DCMAKE_CXX_COMPILER=${CXX_COMPILER} "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}"
      -DCMAKE_BUILD_TYPE=${type} -DCMAKE_RUNTIME_OUTPUT_DIRECTORY=${dir}/bin
      -DEXPECTED_PREFIX=${prefix})
  run("build ${project}" ${CMAKE_COMMAND} --build ${dir} --config "${type}")
  find_program(${project}_program ${project} PATHS ${dir}/bin ${dir}/bin/${type} NO_DEFAULT_PATH NO_CACHE REQUIRED)
  run("run ${project}" ${${project}_program} ${dir})
endforeach()
