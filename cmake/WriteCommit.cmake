# Writes the source tree's commit to a header, which changes only when the commit does:
#   cmake -D SOURCE=DIR -D OUTPUT=FILE -P WriteCommit.cmake
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
                OUTPUT_VARIABLE COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE FAILED)
if(FAILED)
  set(COMMIT unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#define DADRL_COMMIT \"@COMMIT@\"\n" @ONLY)
