# Precompiled headers (clang): the standard library and other people's, never our own; dadrl_library, dadrl_executable
# and dadrl_test use them. A source includes what it needs all the same: g++ builds without them.
#
# Not by target_precompile_headers: its result holds the path of the build folder, so that two folders share nothing in
# ccache. Compiled in / to standard output, the same headers and flags give the same bytes in every folder. The main file
# is one of the system's that is as good as empty: ccache wants to find it again, and to see a regular file.
set(DADRL_PRECOMPILED_FOLDER ${CMAKE_BINARY_DIR}/precompiled)

# Target NAME: DADRL_PRECOMPILED_FOLDER/NAME.pch of HEADERS, which belong to LIBRARIES.
function(dadrl_precompile NAME)
  cmake_parse_arguments(ARG "" "" "HEADERS;LIBRARIES" ${ARGN})
  string(TOUPPER "${CMAKE_BUILD_TYPE}" BUILD_TYPE)
  separate_arguments(FLAGS UNIX_COMMAND
    "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${BUILD_TYPE}} ${CMAKE_CXX20_STANDARD_COMPILE_OPTION}")
  get_directory_property(OPTIONS COMPILE_OPTIONS)
  set(DEFINITIONS)
  foreach(LIBRARY ${ARG_LIBRARIES})
    list(APPEND DEFINITIONS $<TARGET_PROPERTY:${LIBRARY},INTERFACE_COMPILE_DEFINITIONS>)
    list(APPEND OPTIONS $<TARGET_PROPERTY:${LIBRARY},INTERFACE_COMPILE_OPTIONS>)
  endforeach()
  list(TRANSFORM ARG_HEADERS PREPEND "-include;")
  set(PCH ${DADRL_PRECOMPILED_FOLDER}/${NAME}.pch)
  add_custom_command(OUTPUT ${PCH}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${DADRL_PRECOMPILED_FOLDER}
    COMMAND ${CMAKE_CXX_COMPILER} ${FLAGS} ${OPTIONS} "-D$<JOIN:${DEFINITIONS},;-D>" ${ARG_HEADERS}
            -fpch-instantiate-templates -Xclang -fno-pch-timestamp -MD -MF ${PCH}.d -MT ${PCH}
            -x c++-header -o - /usr/include/errno.h > ${PCH}
    WORKING_DIRECTORY / DEPFILE ${PCH}.d COMMAND_EXPAND_LISTS VERBATIM
    COMMENT "Precompiling ${NAME}")
  add_custom_target(${NAME} DEPENDS ${PCH})
endfunction()

# Has the sources of TARGET compiled with NAME; none may have flags of its own that change the language or the processor.
function(dadrl_use_precompiled TARGET NAME)
  if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
    target_compile_options(${TARGET} PRIVATE "SHELL:-include-pch ${DADRL_PRECOMPILED_FOLDER}/${NAME}.pch")
    add_dependencies(${TARGET} ${NAME})
  endif()
endfunction()

if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
  set(HEADERS algorithm array atomic charconv chrono cmath condition_variable cstdint cstring deque filesystem fstream
    functional map memory mutex optional set span sstream string string_view thread unordered_map utility variant vector
    fmt/format.h nlohmann/json.hpp spdlog/spdlog.h tl/expected.hpp)
  set(LIBRARIES fmt::fmt spdlog::spdlog)
  dadrl_precompile(dadrl_headers HEADERS ${HEADERS} LIBRARIES ${LIBRARIES})
  # Apart: every object that sees CLI11 constructs its validators.
  dadrl_precompile(dadrl_command_headers HEADERS ${HEADERS} CLI/CLI.hpp LIBRARIES ${LIBRARIES})
  dadrl_precompile(dadrl_test_headers HEADERS ${HEADERS} gmock/gmock.h gtest/gtest.h
                   LIBRARIES ${LIBRARIES} GTest::gtest)
endif()
