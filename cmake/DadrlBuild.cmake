# Compiler settings and the functions every folder uses:
#   dadrl_library(NAME SOURCES ... LINK ...)     static library dadrl_NAME
#   dadrl_interface(NAME LINK ...)              target dadrl_NAME: the folder's headers and what they need, no code
#   dadrl_executable(NAME SOURCES ... LINK ...)  build/<preset>/bin/NAME
#   dadrl_test(NAME SOURCES ... LINK ... [LABELS ...] [PREFIX ...])  GoogleTest binary, each case registered with CTest
#   dadrl_shared_files(TARGET FOLDER FILES...)   copies of FILES in build/<preset>/share/dadrl/FOLDER, beside bin
# Each target comes with the headers of the folder that defines it, and finds those of what it links (DadrlLayers.cmake).
# PLAIN_HEADERS leaves the precompiled headers out (DadrlHeaders.cmake): for sources with flags of their own.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_program(CCACHE ccache)
if(CCACHE)
  # What ccache wants before it caches a compilation that uses a precompiled header (no code uses __TIME__), and
  # paths that begin here, so that another clone finds what this one compiled.
  set(CACHED_COMPILER env CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_BASEDIR=${CMAKE_SOURCE_DIR}
                          CCACHE_NOHASHDIR=1 ${CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CACHED_COMPILER})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CACHED_COMPILER})
endif()
# Not mold: that of Debian 12 writes programs that the loader refuses, depending on the length of a path.
find_program(LLD ld.lld)
if(LLD AND NOT DADRL_SANITIZE)
  add_link_options(-fuse-ld=lld)
endif()

set(DADRL_SANITIZE "" CACHE STRING "comma separated sanitizers, e.g. address,undefined")
if(DADRL_SANITIZE)
  add_compile_options(-fsanitize=${DADRL_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${DADRL_SANITIZE})
endif()

# Some packages ask for it; who shares precompiled headers must agree.
add_compile_options(-pthread)

add_library(dadrl_warnings INTERFACE)
target_compile_options(dadrl_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Werror
  "$<$<CXX_COMPILER_ID:Clang>:-Wsign-conversion;-Wthread-safety>"
  # g++ means designated initializers too, which clang knows leave members out on purpose.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-missing-field-initializers>)

function(dadrl_configure TARGET)
  cmake_parse_arguments(ARG "" "" "LINK" ${ARGN})
  dadrl_include_root(ROOT)
  target_include_directories(${TARGET} PUBLIC ${ROOT})
  target_link_libraries(${TARGET} PUBLIC ${ARG_LINK} PRIVATE $<BUILD_INTERFACE:dadrl_warnings>)
endfunction()

function(dadrl_library NAME)
  cmake_parse_arguments(ARG "PLAIN_HEADERS" "" "SOURCES;LINK" ${ARGN})
  add_library(dadrl_${NAME} STATIC ${ARG_SOURCES})
  dadrl_configure(dadrl_${NAME} LINK ${ARG_LINK})
  if(NOT ARG_PLAIN_HEADERS)
    dadrl_use_precompiled(dadrl_${NAME} dadrl_headers)
  endif()
endfunction()

function(dadrl_interface NAME)
  cmake_parse_arguments(ARG "" "" "LINK" ${ARGN})
  dadrl_include_root(ROOT)
  add_library(dadrl_${NAME} INTERFACE)
  target_include_directories(dadrl_${NAME} INTERFACE ${ROOT})
  target_link_libraries(dadrl_${NAME} INTERFACE ${ARG_LINK})
endfunction()

function(dadrl_executable NAME)
  cmake_parse_arguments(ARG "PLAIN_HEADERS" "" "SOURCES;LINK" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  dadrl_configure(${NAME} LINK ${ARG_LINK})
  if(CLI11::CLI11 IN_LIST ARG_LINK)
    dadrl_use_precompiled(${NAME} dadrl_command_headers)
  elseif(NOT ARG_PLAIN_HEADERS)
    dadrl_use_precompiled(${NAME} dadrl_headers)
  endif()
endfunction()

function(dadrl_test NAME)
  cmake_parse_arguments(ARG "" "TIMEOUT;PREFIX" "SOURCES;LINK;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  if(DADRL_SANITIZE)
    math(EXPR ARG_TIMEOUT "5 * ${ARG_TIMEOUT}")
  endif()
  add_executable(${NAME} ${ARG_SOURCES})
  dadrl_configure(${NAME} LINK ${ARG_LINK} GTest::gmock GTest::gtest_main)
  dadrl_use_precompiled(${NAME} dadrl_test_headers)
  set_target_properties(${NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  # Processes that a test starts inherit it.
  set(LEAKS "LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/lsan_suppressions.txt:print_suppressions=0")
  set(RACES "TSAN_OPTIONS=set:suppressions=${PROJECT_SOURCE_DIR}/tests/tsan_suppressions.txt")
  gtest_discover_tests(${NAME} DISCOVERY_MODE PRE_TEST TEST_PREFIX "${ARG_PREFIX}"
                       PROPERTIES ENVIRONMENT "${LEAKS}" ENVIRONMENT_MODIFICATION "${RACES}"
                                  TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}")
endfunction()

# Ends with an empty folder where there are no files.
function(dadrl_shared_files TARGET FOLDER)
  set(OUTPUT ${CMAKE_BINARY_DIR}/share/dadrl/${FOLDER})
  set(PRODUCTS)
  foreach(FILE ${ARGN})
    cmake_path(GET FILE FILENAME NAME)
    add_custom_command(OUTPUT ${OUTPUT}/${NAME}
      COMMAND ${CMAKE_COMMAND} -E copy ${FILE} ${OUTPUT}/${NAME}
      DEPENDS ${FILE} VERBATIM)
    list(APPEND PRODUCTS ${OUTPUT}/${NAME})
  endforeach()
  add_custom_target(${TARGET} ALL DEPENDS ${PRODUCTS} COMMAND ${CMAKE_COMMAND} -E make_directory ${OUTPUT})
endfunction()
