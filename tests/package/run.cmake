# SPDX-License-Identifier: MIT
# Run by ctest: installs the build into a folder of its own, then configures, builds and runs the projects beside this
# file and the example of the documentation against it. Any step that fails ends the test with that step's output.
set(prefix ${WORK_DIR}/install)
file(REMOVE_RECURSE ${prefix})

function(run step)
  message(STATUS "${step}")
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${step} failed (${result}):\n${output}")
  endif()
endfunction()

run("install" ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix} --config "${CONFIG}")

# What is installed must be movable: no file of the package may name the source or the build folder.
file(GLOB_RECURSE package_files ${prefix}/*alidade*.cmake)
if(NOT package_files)
  message(FATAL_ERROR "no CMake package was installed below ${prefix}")
endif()
foreach(file IN LISTS package_files)
  file(READ ${file} text)
  foreach(folder IN ITEMS ${SOURCE_DIR} ${BUILD_DIR})
    string(FIND "${text}" "${folder}" position)
    if(NOT position EQUAL -1)
      message(FATAL_ERROR "${file} names ${folder}")
    endif()
  endforeach()
endforeach()

if(SANITIZE)
  string(APPEND CXX_FLAGS " -fsanitize=${SANITIZE} -fno-sanitize-recover=all")
endif()
# A list as one argument: its semicolons must survive the list of arguments that it becomes a part of.
string(JOIN "\\;" prefix_path ${prefix} ${PREFIX_PATH})
foreach(source IN ITEMS ${CMAKE_CURRENT_LIST_DIR}/camera_only ${CMAKE_CURRENT_LIST_DIR}/files_only
                        ${CMAKE_CURRENT_LIST_DIR}/everything ${CMAKE_CURRENT_LIST_DIR}/readme
                        ${SOURCE_DIR}/docs/examples/test_harness)
  get_filename_component(project ${source} NAME)
  set(dir ${WORK_DIR}/${project})
  file(REMOVE_RECURSE ${dir})
  run("configure ${project}" ${CMAKE_COMMAND} -S ${source} -B ${dir} -G "${GENERATOR}"
      -DCMAKE_PREFIX_PATH=${prefix_path} -DCMAKE_CXX_COMPILER=${CXX_COMPILER} "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}"
      -DCMAKE_BUILD_TYPE=${CONFIG} -DCMAKE_RUNTIME_OUTPUT_DIRECTORY=${dir}/bin
      -DEXPECTED_PREFIX=${prefix})
  run("build ${project}" ${CMAKE_COMMAND} --build ${dir} --config "${CONFIG}")
  find_program(${project}_program ${project} PATHS ${dir}/bin ${dir}/bin/${CONFIG} NO_DEFAULT_PATH NO_CACHE REQUIRED)
  run("run ${project}" ${${project}_program} ${dir})
endforeach()
