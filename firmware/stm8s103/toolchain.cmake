# The STM8 and its compiler, sdcc, which brings assembler and linker. It knows no C++.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR stm8)
set(CMAKE_C_COMPILER sdcc)
set(CMAKE_C_FLAGS_INIT -mstm8)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
