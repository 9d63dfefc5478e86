# An image that needs more than its budget is an error.
execute_process(COMMAND avr-size ${ELF} OUTPUT_VARIABLE sizes COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "\n +([0-9]+)[ \t]+([0-9]+)[ \t]+([0-9]+)" line "${sizes}")
math(EXPR flash "${CMAKE_MATCH_1} + ${CMAKE_MATCH_2}")
math(EXPR ram "${CMAKE_MATCH_2} + ${CMAKE_MATCH_3}")
message(STATUS "${ELF}: ${flash} bytes of flash (budget ${FLASH}), ${ram} bytes of RAM (budget ${RAM})")
if(flash GREATER FLASH OR ram GREATER RAM)
  message(FATAL_ERROR "${ELF} is larger than its budget")
endif()
