# SPDX-License-Identifier: MIT
# For -DALIDADE_PORTABLE=ON (scripts/portable), after all packages were found: Debian's archives take the place of its
# shared libraries, so that the program and the Python module need nothing but glibc.
set(ALIDADE_TBB_SOURCE "" CACHE PATH "Unpacked source of Debian's package onetbb")

# What has no archive in Debian, or one that cannot be linked into a Python module. OpenCV's loops run on TBB, which is
# compiled here, CHOLMOD's on one thread, and fmt's functions come from its headers. The rest is never called, and ends the
# program if it is: OpenCV's decoders of formats that image_container.h does not know, CHOLMOD's ordering by METIS, OpenGL,
# and what LAPACK prints of wrong arguments. Functions that are called and need not succeed return: of the constructors
# of those decoders, and libunwind's, without which an error of glog comes without the stack.
execute_process(COMMAND ${CMAKE_NM} -u --format=just-symbols ${OpenCV_INSTALL_PATH}/lib/${CMAKE_LIBRARY_ARCHITECTURE}/libopencv_imgcodecs.a
                OUTPUT_VARIABLE symbols ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]*(GDAL|4gdcm|7Imf_3_1|opj_)[^\n]*" ending "${symbols}")
list(REMOVE_DUPLICATES ending)
set(returning ${ending})
list(FILTER returning INCLUDE REGEX "GDALAllRegister|ChromaticitiesC")
list(REMOVE_ITEM ending ${returning})
list(APPEND returning _Ux86_64_getcontext _ULx86_64_init_local _ULx86_64_step _ULx86_64_get_reg)
list(APPEND ending METIS_NodeND METIS_ComputeVertexSeparator glXGetProcAddressARB glXGetCurrentDisplay glXGetCurrentContext
     _gfortran_st_write _gfortran_st_write_done _gfortran_stop_string _gfortran_transfer_character_write
     _gfortran_transfer_integer_write _gfortrani_xmallocarray _gfortrani_runtime_error)
foreach(names IN ITEMS ending returning)
  list(TRANSFORM ${names} REPLACE "(.+)" ".globl \\1\n\\1:\n")
  string(JOIN "" ${names} ${${names}})
endforeach()
file(CONFIGURE OUTPUT absent.cc @ONLY CONTENT [[
#include <cstdio>
asm(R"(
@ending@ ud2
@returning@ mov $-1, %eax
 ret)");
extern "C" {
void GOMP_parallel(void (*run)(void*), void* data, unsigned, unsigned) { run(data); }
int omp_get_num_threads() { return 1; }
int omp_get_thread_num() { return 0; }
// Most archives are compiled for programs and address glibc's data directly, which a module cannot: they get copies.
extern FILE *__real_stdin, *__real_stdout, *__real_stderr;
FILE *__wrap_stdin, *__wrap_stdout, *__wrap_stderr;
__attribute__((constructor(101))) void setStreams() {
  __wrap_stdin = __real_stdin, __wrap_stdout = __real_stdout, __wrap_stderr = __real_stderr;
}
char __wrap___libc_single_threaded = 0;
}
]])
file(GLOB tbb_sources ${ALIDADE_TBB_SOURCE}/src/tbb/*.cpp)
if(NOT tbb_sources)
  message(FATAL_ERROR "ALIDADE_TBB_SOURCE is '${ALIDADE_TBB_SOURCE}', which has no src/tbb/*.cpp; start scripts/portable, which unpacks them")
endif()
add_library(alidade_absent STATIC ${CMAKE_CURRENT_BINARY_DIR}/absent.cc ${tbb_sources})
set_target_properties(alidade_absent PROPERTIES POSITION_INDEPENDENT_CODE ON)
target_include_directories(alidade_absent PRIVATE ${ALIDADE_TBB_SOURCE}/include)
target_compile_definitions(alidade_absent PRIVATE __TBB_BUILD __TBB_DYNAMIC_LOAD_ENABLED=0 __TBB_SOURCE_DIRECTLY_INCLUDED=1)
target_compile_options(alidade_absent PRIVATE -mrtm -mwaitpkg -w)
set_target_properties(fmt::fmt PROPERTIES INTERFACE_COMPILE_DEFINITIONS FMT_HEADER_ONLY)

# The archive instead of each shared library that the packages name.
set(stand_in ${CMAKE_CURRENT_BINARY_DIR}/libalidade_absent.a)
get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
foreach(target IN LISTS targets)
  foreach(property IN ITEMS IMPORTED_LOCATION IMPORTED_LOCATION_NONE IMPORTED_LOCATION_RELEASE INTERFACE_LINK_LIBRARIES)
    get_target_property(value ${target} ${property})
    if(value MATCHES "/lib[^;]*[.]so")
      string(REGEX REPLACE "/[^;]*/lib(fmt|tbb)[.]so[0-9.]*" "${stand_in}" value "${value}")
      string(REGEX REPLACE "/lib(lapack|blas)[.]so" "/atlas/lib\\1.a" value "${value}")  # not an alternative of update-alternatives
      string(REGEX REPLACE "(/lib[^/;]*)[.]so[0-9.]*" "\\1.a" value "${value}")
      set_property(TARGET ${target} PROPERTY ${property} "${value}")
    endif()
  endforeach()
endforeach()

# What the archives need in their turn.
set(CMAKE_SKIP_RPATH ON)
add_link_options(-static-libstdc++ -static-libgcc LINKER:-z,text LINKER:-Bstatic
  LINKER:--wrap=stdin,--wrap=stdout,--wrap=stderr,--wrap=__libc_single_threaded LINKER:-Map=${PROJECT_BINARY_DIR}/$<TARGET_PROPERTY:NAME>.map)
string(APPEND CMAKE_CXX_STANDARD_LIBRARIES
       " -Wl,--start-group ${stand_in} -l:atlas/liblapack.a -l:atlas/libblas.a -latlas -lgfortran -ljpeg -ltiff -lpng -lwebp -lwebpmux -lzstd -llzma -ljbig -ldeflate -lLerc -lz"
       " -lpixman-1 -lfontconfig -lfreetype -lexpat -lbrotlidec -lbrotlicommon -luuid -Wl,--end-group -Wl,-Bdynamic")
