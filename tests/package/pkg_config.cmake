# SPDX-License-Identifier: MIT
# Run by ctest: compiles programs of users with what pkg-config says of the installation of install.cmake, each in one
# line, and runs them.
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)

find_program(pkg_config pkg-config)
if(NOT pkg_config)
  message("SKIPPED: pkg-config was not found (Debian: pkgconf)")
  return()
endif()
file(GLOB_RECURSE pc_files ${prefix}/*/pkgconfig/alidade*.pc)
list(LENGTH pc_files num_pc_files)
if(NOT num_pc_files EQUAL 7)
  message(FATAL_ERROR "expected alidade.pc and one for each of 6 components below ${prefix}, not: ${pc_files}")
endif()
list(GET pc_files 0 pc_file)
get_filename_component(pc_folder ${pc_file} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
if(SANITIZE)
  string(APPEND CXX_FLAGS " -fsanitize=${SANITIZE} -fno-sanitize-recover=all")
endif()
separate_arguments(cxx_flags UNIX_COMMAND "${CXX_FLAGS}")

# Sets RESULT to the flags of the modules: get_flags(RESULT MODULE...)
function(get_flags result)
  execute_process(COMMAND ${pkg_config} --cflags --libs ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE flags
                  ERROR_VARIABLE errors OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "pkg-config ${ARGN} failed (${code}):\n${errors}")
  endif()
  separate_arguments(flags UNIX_COMMAND "${flags}")
  set(${result} ${flags} PARENT_SCOPE)
endfunction()

# Each of them alone is complete: a program links that takes all of its archives.
set(dir ${WORK_DIR}/pkg_config)
file(REMOVE_RECURSE ${dir})
file(WRITE ${dir}/nothing.cc "int main() {}\n")
foreach(file IN LISTS pc_files)
  get_filename_component(module ${file} NAME_WE)
  get_flags(flags ${module})
  run("link all of ${module}" ${CXX_COMPILER} ${cxx_flags} ${dir}/nothing.cc -o ${dir}/${module}
      -Wl,--whole-archive ${flags} -Wl,--no-whole-archive)
endforeach()

# A program that only projects points links no other package.
get_flags(flags alidade-camera)
list(FILTER flags INCLUDE REGEX "^-l")
if(NOT flags STREQUAL "-lalidade_camera;-lalidade_geometry;-lalidade_core")
  message(FATAL_ERROR "alidade-camera links other libraries than its own: ${flags}")
endif()

function(compile_and_run name source)
  get_flags(flags ${ARGN})
  run("compile ${name} with ${ARGN}" ${CXX_COMPILER} -std=c++20 ${cxx_flags} ${source} -o ${dir}/${name} ${flags})
  run("run ${name}" ${dir}/${name} ${dir})
endfunction()
compile_and_run(camera ${CMAKE_CURRENT_LIST_DIR}/pkg_config/camera.cc alidade-camera)
compile_and_run(files ${CMAKE_CURRENT_LIST_DIR}/pkg_config/files.cc alidade-files)
compile_and_run(rig ${SOURCE_DIR}/docs/examples/rig/rig.cc alidade-rig alidade-files)
