include("${CMAKE_CURRENT_LIST_DIR}/../../avr_toolchain.cmake")
