# cmake -DCOMPILER= -DFLAGS= -DINCLUDE= -DSOURCE= -P check.cmake
# Holds one program against its three demands: the twin compiles, the bad line does not, and for
# the reason that the line `// error: <regex>` of the source gives.

file(STRINGS "${SOURCE}" error_line REGEX "^// error: " LIMIT_COUNT 1)
string(REGEX REPLACE "^// error: " "" reason "${error_line}")
if(NOT reason)
  message(FATAL_ERROR "${SOURCE} has no `// error: <regex>` line")
endif()

set(compile "${COMPILER}" ${FLAGS} -fsyntax-only "-I${INCLUDE}" "${SOURCE}")
# Diagnostics are matched as text, so they must not be translated.
set(ENV{LC_ALL} C)

execute_process(COMMAND ${compile} RESULT_VARIABLE code ERROR_VARIABLE diagnostics)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "the twin does not compile: ${SOURCE}\n${diagnostics}")
endif()

execute_process(COMMAND ${compile} -DMUST_NOT_COMPILE
  RESULT_VARIABLE code ERROR_VARIABLE diagnostics)
if(code EQUAL 0)
  message(FATAL_ERROR "compiles although it must not: ${SOURCE}")
endif()
if(NOT diagnostics MATCHES "${reason}")
  message(FATAL_ERROR "fails, but not because of `${reason}`: ${SOURCE}\n${diagnostics}")
endif()
