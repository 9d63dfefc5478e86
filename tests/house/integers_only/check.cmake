# cmake -DCOMPILER= -DFLAGS= -DINCLUDE= -DSOURCE= -DMUST_PASS=ON|OFF -P check.cmake
# Compiles one source as for a processor without a floating-point unit, and reads the machine code:
# no call of a floating-point routine, and no division.

set(ENV{LC_ALL} C)
execute_process(
  COMMAND "${COMPILER}" ${FLAGS} -O2 -mgeneral-regs-only -Wfloat-conversion -S -o - "-I${INCLUDE}"
    "${SOURCE}"
  RESULT_VARIABLE code OUTPUT_VARIABLE assembly ERROR_VARIABLE diagnostics)

set(found "")
if(NOT code EQUAL 0)
  set(found "does not compile without floating-point registers:\n${diagnostics}")
elseif(assembly MATCHES "[^\n]*__(add|sub|mul|div|neg|float|floatun|fix|fixuns|cmp|unord|eq|ne|lt|le|gt|ge|extend|trunc)[a-z]*[sdxt]f[a-z]*[23][^\n]*")
  set(found "calls a floating-point routine: ${CMAKE_MATCH_0}")
elseif(assembly MATCHES "\n[ \t]+(i?div|udiv|sdiv)[bwlq]?[ \t][^\n]*")
  set(found "divides: ${CMAKE_MATCH_0}")
elseif(assembly MATCHES "[^\n]*__u?(div|mod)[a-z]*[dt]i[34][^\n]*")
  set(found "divides: ${CMAKE_MATCH_0}")
endif()

if(MUST_PASS AND found)
  message(FATAL_ERROR "${SOURCE} ${found}")
elseif(NOT MUST_PASS AND NOT found)
  message(FATAL_ERROR "${SOURCE} passes although it must not: this check sees nothing")
endif()
