# One room of the house: a folder below src/sinew, its library sinew::<name>, and the unit tests
# that stand beside the code as *_test.cc.

set(CMAKE_CXX_STANDARD 23)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}")

add_library(sinew_options INTERFACE)
target_include_directories(sinew_options INTERFACE "${CMAKE_SOURCE_DIR}/src")
# No code here reads errno after a math call or unmasks floating-point traps; saying so lets the
# compiler use the square-root instruction and turn short branches into selects.
target_compile_options(sinew_options INTERFACE
  -Wall -Wextra -Wconversion -Wshadow -Werror -fno-math-errno -fno-trapping-math
  # g++ 12 reports "literal" + std::string as overlapping memory (GCC bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)

if(SINEW_TESTS)
  find_package(GTest REQUIRED)
  # g++ reads GoogleTest once instead of once for every file of tests. Not with clang, where an
  # include that is missing is found, and not with ccache, which keeps nothing of such compilations.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    set(sinew_test_header ON)
    file(WRITE "${CMAKE_BINARY_DIR}/test_header.cc" "")
    add_library(sinew_test_header OBJECT "${CMAKE_BINARY_DIR}/test_header.cc")
    target_link_libraries(sinew_test_header PRIVATE sinew_options GTest::gtest)
    target_precompile_headers(sinew_test_header PRIVATE
      <gtest/gtest.h> <algorithm> <array> <chrono> <cmath> <functional> <optional> <random> <span>
      <string> <variant> <vector>)
  endif()
endif()

# sinew_test(<name> SOURCES ... LIBRARIES ... [SHARDS n]): one GoogleTest program, registered with
# ctest; with SHARDS as n processes side by side.
function(sinew_test name)
  cmake_parse_arguments(ARG "" "SHARDS" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE sinew_options ${ARG_LIBRARIES} GTest::gtest_main)
  if(sinew_test_header)
    target_precompile_headers(${name} REUSE_FROM sinew_test_header)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # g++ 12 reports sizes that no string and no vector ever has.
    target_compile_options(${name} PRIVATE
      -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
  endif()
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/tests")
  set(results "${CMAKE_BINARY_DIR}/test_results/${name}")
  if(ARG_SHARDS)
    add_test(NAME ${name} COMMAND "${CMAKE_SOURCE_DIR}/tests/support/side_by_side.sh"
      $<TARGET_FILE:${name}> ${ARG_SHARDS} "${results}")
  else()
    add_test(NAME ${name} COMMAND ${name} "--gtest_output=json:${results}.json")
  endif()
endfunction()

# sinew_room(<name> LIBRARIES ...): the library of the folder that calls it.
# TEST_LIBRARIES are linked into its unit tests only.
function(sinew_room name)
  cmake_parse_arguments(ARG "" "" "LIBRARIES;TEST_LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS *.cc)
  file(GLOB tests CONFIGURE_DEPENDS *_test.cc)
  if(tests)
    list(REMOVE_ITEM sources ${tests})
  endif()
  if(sources)
    add_library(sinew_${name} STATIC ${sources})
    target_link_libraries(sinew_${name} PUBLIC sinew_options ${ARG_LIBRARIES})
  else()
    add_library(sinew_${name} INTERFACE)
    target_link_libraries(sinew_${name} INTERFACE sinew_options ${ARG_LIBRARIES})
  endif()
  add_library(sinew::${name} ALIAS sinew_${name})
  if(SINEW_TESTS AND tests)
    sinew_test(${name}_test SOURCES ${tests}
      LIBRARIES sinew_${name} sinew_test_support ${ARG_TEST_LIBRARIES})
  endif()
endfunction()
