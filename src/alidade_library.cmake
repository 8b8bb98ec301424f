# SPDX-License-Identifier: MIT
# Warnings and sanitizers, for our own targets only: nothing reaches a parent project or a consumer.
function(alidade_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # g++ 12 warns of copies inside std::string's operator+ (GCC bugs 105329, 105651).
    target_compile_options(${target} PRIVATE -Wno-restrict -Wno-stringop-overflow -Wno-array-bounds)
    # Collecting garbage below 512 MB takes a tenth of the compilation and saves little: the largest source needs 1.6 GB
    # in any case, a test 0.7 GB instead of 0.6.
    target_compile_options(${target} PRIVATE --param=ggc-min-heapsize=524288)
  endif()
  if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64|amd64")
    # The roundings of x86-64, whose baseline has no fused multiplication.
    target_compile_options(${target} PRIVATE -ffp-contract=off)
  endif()
  if(ALIDADE_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(ALIDADE_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${ALIDADE_SANITIZE} -fno-sanitize-recover=all
                                             -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${ALIDADE_SANITIZE})
    # Under AddressSanitizer Eigen takes another allocator than in the Ceres library, which is built without, and memory
    # goes from one to the other.
    target_compile_definitions(${target} PRIVATE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  endif()
endfunction()

# Installed libraries keep their templates to themselves (see seal_archive.cmake) where the tools can do that. With a
# sanitizer, programs need the library's flags anyway.
set(ALIDADE_CAN_SEAL FALSE)
if(CMAKE_NM AND CMAKE_OBJCOPY AND CMAKE_LINKER AND NOT ALIDADE_SANITIZE)
  execute_process(COMMAND ${CMAKE_LINKER} --help OUTPUT_VARIABLE alidade_linker_help ERROR_QUIET)
  if(alidade_linker_help MATCHES "--force-group-allocation")
    set(ALIDADE_CAN_SEAL TRUE)
  endif()
endif()
if(NOT ALIDADE_CAN_SEAL)
  message(STATUS "Programs that use the installed libraries must be compiled with the libraries' flags")
endif()

# Most of a build goes into templates, which each compilation instantiates anew.
function(alidade_compile_together target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${ALIDADE_UNITY} UNITY_BUILD_BATCH_SIZE 8)
endfunction()

set(ALIDADE_TEXT_ROOMS record files print report)  # what they compute is little

# One folder, one target: alidade_add_library(core HEADERS a.h SOURCES a.cc PUBLIC dep PRIVATE dep). A static library,
# except with BUILD_SHARED_LIBS.
# The links are the import rule: a layer that does not link another one cannot use it.
function(alidade_add_library name)
  cmake_parse_arguments(ARG "" "" "HEADERS;SOURCES;PUBLIC;PRIVATE" ${ARGN})
  set(target alidade_${name})
  add_library(${target} ${ARG_SOURCES})
  add_library(alidade::${name} ALIAS ${target})
  alidade_compile_options(${target})
  alidade_compile_together(${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON
                                             VERIFY_INTERFACE_HEADER_SETS ON VERSION ${PROJECT_VERSION}
                                             SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
                                             DEFINE_SYMBOL "")  # precompiled headers are shared
  if(BUILD_SHARED_LIBS)
    set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN")
  endif()
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR}/src FILES ${ARG_HEADERS})
  target_link_libraries(${target} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  # What most sources include, compiled once for the rooms that compute and once for those of text: a precompiled header
  # fixes the optimisation of the sources that use it. They must include it themselves too: scripts/lint --tidy and
  # scripts/sanitize build without.
  set(first geometry)
  if(name IN_LIST ALIDADE_TEXT_ROOMS)
    set(first record)
    target_compile_options(${target} PRIVATE ${ALIDADE_TEXT_OPTIONS})
  endif()
  if(name STREQUAL first)
    target_precompile_headers(${target} PRIVATE <Eigen/Cholesky> <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <algorithm>
                                                <array> <cmath> <limits> <numbers> <optional> <span> <string>
                                                <string_view> <utility> <vector>)
  elseif(NOT name STREQUAL "core")
    target_precompile_headers(${target} REUSE_FROM alidade_${first})
  endif()
  set_property(GLOBAL APPEND PROPERTY ALIDADE_LIBRARIES ${name})  # from the bottom up, for pkg_config.cmake
  set(export_set alidade-targets)
  foreach(group IN LISTS ALIDADE_GROUPS)
    if(name IN_LIST ALIDADE_${group}_LIBRARIES)
      set(export_set alidade-${group}-targets)
    endif()
  endforeach()
  install(TARGETS ${target} EXPORT ${export_set}
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT program NAMELINK_COMPONENT development
          FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
  if(ALIDADE_CAN_SEAL AND NOT BUILD_SHARED_LIBS)
    set(archive "${CMAKE_INSTALL_LIBDIR}/$<TARGET_FILE_NAME:${target}>")
    if(NOT IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}")
      set(archive "\${CMAKE_INSTALL_PREFIX}/${archive}")
    endif()
    install(CODE "execute_process(COMMAND \"${CMAKE_COMMAND}\" -D \"ARCHIVE=\$ENV{DESTDIR}${archive}\"
                                          -D \"COMPILER=${CMAKE_CXX_COMPILER}\" -D COMPILER_ID=${CMAKE_CXX_COMPILER_ID}
                                          -D \"NM=${CMAKE_NM}\" -D \"OBJCOPY=${CMAKE_OBJCOPY}\" -D \"AR=${CMAKE_AR}\"
                                          -P \"${PROJECT_SOURCE_DIR}/src/seal_archive.cmake\"
                                  COMMAND_ERROR_IS_FATAL ANY)"
            COMPONENT development)
  endif()
endfunction()
