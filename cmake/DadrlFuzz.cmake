# A fuzz target for one decoder (tests/fuzz/README.md):
#   dadrl_fuzzer(NAME SOURCES ... LINK ...)  fuzz_NAME_test: its seeds and a fixed number of mutants, in every build
#                                            bin/fuzz_NAME: with DADRL_FUZZ, the libFuzzer executable
# Target dadrl_fuzzers builds all of the latter (tests/run_fuzzers.sh).

option(DADRL_FUZZ "build the libFuzzer executables (clang)" OFF)
if(DADRL_FUZZ)
  add_custom_target(dadrl_fuzzers)
  # Coverage is what guides it: whatever may be under test must report it.
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

# For the folders of code that decodes nothing and computes much: coverage of it would guide no fuzzer and slow down the
# tests that share its build.
macro(dadrl_without_coverage)
  if(DADRL_FUZZ)
    add_compile_options(-fno-sanitize-coverage=edge,inline-8bit-counters,indirect-calls,trace-cmp,pc-table,stack-depth)
  endif()
endmacro()

# What all targets share, compiled once. Objects: a library would leave out tests that nobody calls.
function(dadrl_fuzz_harness)
  set(HARNESS ${PROJECT_SOURCE_DIR}/tests/fuzz)
  add_library(dadrl_fuzz_mutations OBJECT ${HARNESS}/harness.cpp ${HARNESS}/mutation_test.cpp)
  dadrl_configure(dadrl_fuzz_mutations LINK dadrl_util dadrl_io GTest::gtest)
  if(DADRL_FUZZ)
    add_library(dadrl_fuzz_main OBJECT ${HARNESS}/harness.cpp ${HARNESS}/libfuzzer_main.cpp)
    dadrl_configure(dadrl_fuzz_main LINK dadrl_util dadrl_io)
  endif()
endfunction()

function(dadrl_fuzzer NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  if(NOT TARGET dadrl_fuzz_mutations)
    dadrl_fuzz_harness()
  endif()
  dadrl_test(fuzz_${NAME}_test SOURCES ${ARG_SOURCES} LINK dadrl_fuzz_mutations ${ARG_LINK} PREFIX fuzz_${NAME}.)
  if(DADRL_FUZZ)
    dadrl_executable(fuzz_${NAME} SOURCES ${ARG_SOURCES} LINK dadrl_fuzz_main ${ARG_LINK})
    target_link_options(fuzz_${NAME} PRIVATE -fsanitize=fuzzer)
    add_dependencies(dadrl_fuzzers fuzz_${NAME})
  endif()
endfunction()
