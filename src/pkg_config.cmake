# SPDX-License-Identifier: MIT
# Files for pkg-config, made from what the targets link.
#
# The libraries are static archives, so programs must link all that these need too. All of it therefore stands in
# Requires and Libs: pkg-config reads Requires.private and Libs.private only with --static, which programs do not use
# that link everything else dynamically.

# What a target of another package is for pkg-config: a module, or flags where the package has no module. Plain names are
# libraries.
set(alidade_module_Eigen3::Eigen eigen3)
set(alidade_module_fmt::fmt fmt)
set(alidade_module_pugixml::pugixml pugixml)
set(alidade_module_yaml-cpp::yaml-cpp yaml-cpp)
set(alidade_module_JPEG::JPEG libjpeg)
set(alidade_module_TIFF::TIFF libtiff-4)
set(alidade_module_ZLIB::ZLIB zlib)
set(alidade_flags_Threads::Threads -pthread)
set(alidade_flags_Ceres::ceres -lceres -lglog)      # glog, because the headers of Ceres log
set(alidade_flags_nlohmann_json::nlohmann_json "")  # no library, and no installed header includes it

# Appends to the list RESULT what the library needs, directly or not: names of our libraries as alidade::NAME, others as
# CMake knows them.
function(alidade_collect_links library result)
  set(all ${${result}})
  get_target_property(links alidade_${library} INTERFACE_LINK_LIBRARIES)
  foreach(link IN LISTS links)
    string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" link "${link}")
    if(NOT link IN_LIST all)
      list(APPEND all "${link}")
      if(link MATCHES "^alidade::(.*)$")
        alidade_collect_links(${CMAKE_MATCH_1} all)
      endif()
    endif()
  endforeach()
  set(${result} "${all}" PARENT_SCOPE)
endfunction()

# Installs NAME.pc, with which a program links the libraries that follow: alidade_add_pkg_config(NAME DESCRIPTION camera)
function(alidade_add_pkg_config ARG_NAME ARG_DESCRIPTION)
  set(links ${ARGN})
  list(TRANSFORM links PREPEND alidade::)
  foreach(library IN LISTS ARGN)
    alidade_collect_links(${library} links)
  endforeach()

  # A linker that reads archives once needs those that use others first.
  get_property(libraries GLOBAL PROPERTY ALIDADE_LIBRARIES)
  list(REVERSE libraries)
  set(libs "")
  foreach(library IN LISTS libraries)
    if("alidade::${library}" IN_LIST links)
      list(APPEND libs -lalidade_${library})
    endif()
  endforeach()
  list(FILTER links EXCLUDE REGEX "^alidade::")
  set(requires "")
  foreach(link IN LISTS links)
    if(DEFINED alidade_module_${link})
      list(APPEND requires ${alidade_module_${link}})
    elseif(DEFINED alidade_flags_${link})
      list(APPEND libs ${alidade_flags_${link}})
    elseif(link MATCHES "^[A-Za-z0-9_][A-Za-z0-9_+-]*$")
      list(APPEND libs -l${link})
    else()
      message(FATAL_ERROR "${ARG_NAME}.pc: what pkg-config calls '${link}' is not known; add it to src/pkg_config.cmake")
    endif()
  endforeach()
  list(JOIN requires ", " requires)
  list(JOIN libs " " libs)

  # Relative to the file, so that an installation may be moved.
  set(folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  if(IS_ABSOLUTE "${folder}")
    set(prefix ${CMAKE_INSTALL_PREFIX})
  else()
    file(RELATIVE_PATH up /${folder} /)
    string(REGEX REPLACE "/$" "" up "${up}")
    set(prefix "\${pcfiledir}/${up}")
  endif()
  foreach(dir IN ITEMS lib include)
    string(TOUPPER CMAKE_INSTALL_${dir}DIR variable)
    set(${dir}dir ${${variable}})
    if(NOT IS_ABSOLUTE "${${dir}dir}")
      string(PREPEND ${dir}dir "\${prefix}/")
    endif()
  endforeach()
  configure_file(${PROJECT_SOURCE_DIR}/src/alidade.pc.in ${PROJECT_BINARY_DIR}/${ARG_NAME}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${ARG_NAME}.pc DESTINATION ${folder} COMPONENT development)
endfunction()
