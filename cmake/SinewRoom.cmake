# One room of the house: a folder below src/sinew, its library sinew::<name>, and the unit tests
# that stand beside the code as *_test.cc.

set(CMAKE_CXX_STANDARD 23)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}")

add_library(sinew_options INTERFACE)
target_include_directories(sinew_options INTERFACE "${CMAKE_SOURCE_DIR}/src")
# No code here reads errno after a math call or unmasks floating-point traps; saying so lets the
# compiler use the square-root instruction and turn short branches into selects.
target_compile_options(sinew_options INTERFACE
  -Wall -Wextra -Wconversion -Wshadow -Werror -fno-math-errno -fno-trapping-math
  # g++ 12 reports overlaps and sizes in its own strings and vectors that none of them ever has
  # (GCC bugs 105651 and 105329).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict;-Wno-array-bounds>
  $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow;-Wno-stringop-overread>)

# A multiply-add that is fused rounds once and not twice: one seed would not be one run on every
# processor. x86-64 has none unless it is asked for, as dispatch.h does for its wide versions.
if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(sinew_options INTERFACE -ffp-contract=off)
endif()

# g++ reads what most files of a target read once for all of them. Not with clang, where an include
# that is missing is found, and not with ccache, which keeps nothing of such compilations.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(sinew_read_once ON)
endif()
set(sinew_usual_headers <algorithm> <array> <chrono> <cmath> <cstdint> <expected> <functional>
  <limits> <map> <memory> <optional> <span> <string> <string_view> <utility> <variant> <vector>)

# Reading a header for all costs as much as five files or so save by it: a target of few batches is
# better without.

# sinew_headers(<target> <header>...): the usual ones and these are read once for the whole target.
# In angle brackets, ours too: CMake takes a name in quotes for a file beside the CMakeLists.txt.
function(sinew_headers target)
  if(sinew_read_once)
    target_precompile_headers(${target} PRIVATE ${sinew_usual_headers} ${ARGN})
  endif()
endfunction()

# sinew_batches(<target>...): its files are compiled six at a time, each header read once for them,
# and what templates make of it once. For targets in which no two files give one name to two things;
# a target that is not built here is passed over.
function(sinew_batches)
  foreach(target IN LISTS ARGN)
    if(TARGET ${target})
      set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
    endif()
  endforeach()
endfunction()

# sinew_alone(<file>...): these are compiled by themselves all the same.
function(sinew_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# The code of tests is compiled more often than it runs.
add_library(sinew_test_options INTERFACE)
target_compile_options(sinew_test_options INTERFACE $<$<CONFIG:Release>:-O1>)

if(SINEW_TESTS)
  find_package(GTest REQUIRED)
  if(sinew_read_once)
    file(WRITE "${CMAKE_BINARY_DIR}/test_header.cc" "")
    add_library(sinew_test_header OBJECT "${CMAKE_BINARY_DIR}/test_header.cc")
    target_link_libraries(sinew_test_header PRIVATE
      sinew_options sinew_test_options GTest::gtest)
    sinew_headers(sinew_test_header <gtest/gtest.h> <random>)
  endif()
endif()

# sinew_test(<name> SOURCES ... LIBRARIES ... [HEADERS ...] [SHARDS n]): one GoogleTest program,
# registered with ctest; with SHARDS as n processes side by side. HEADERS are read once.
function(sinew_test name)
  cmake_parse_arguments(ARG "" "SHARDS" "SOURCES;LIBRARIES;HEADERS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE
    sinew_options sinew_test_options ${ARG_LIBRARIES} GTest::gtest_main)
  if(ARG_HEADERS)
    sinew_headers(${name} <gtest/gtest.h> <random> ${ARG_HEADERS})
  elseif(sinew_read_once)
    target_precompile_headers(${name} REUSE_FROM sinew_test_header)
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

# sinew_long(<test> <seconds>): begun before shorter ones, so that no core waits for it at the end.
function(sinew_long test seconds)
  if(TEST ${test})
    set_tests_properties(${test} PROPERTIES COST ${seconds})
  endif()
endfunction()

# sinew_room(<name> LIBRARIES ... [HEADERS ...]): the library of the folder that calls it, with the folders in it.
# TEST_LIBRARIES are linked into its unit tests only. HEADERS are read once for the library and once
# for its tests, TEST_HEADERS for the tests. SHARDS as in sinew_test.
function(sinew_room name)
  cmake_parse_arguments(ARG "" "SHARDS" "LIBRARIES;TEST_LIBRARIES;HEADERS;TEST_HEADERS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS *.c *.cc */*.cc)
  file(GLOB tests CONFIGURE_DEPENDS *_test.cc */*_test.cc)
  if(tests)
    list(REMOVE_ITEM sources ${tests})
  endif()
  if(sources)
    add_library(sinew_${name} STATIC ${sources})
    target_link_libraries(sinew_${name} PUBLIC sinew_options ${ARG_LIBRARIES})
    if(ARG_HEADERS)
      sinew_headers(sinew_${name} ${ARG_HEADERS})
    endif()
  else()
    add_library(sinew_${name} INTERFACE)
    target_link_libraries(sinew_${name} INTERFACE sinew_options ${ARG_LIBRARIES})
  endif()
  add_library(sinew::${name} ALIAS sinew_${name})
  if(SINEW_TESTS AND tests)
    sinew_test(${name}_test SOURCES ${tests}
      LIBRARIES sinew_${name} sinew_test_support ${ARG_TEST_LIBRARIES}
      HEADERS ${ARG_HEADERS} ${ARG_TEST_HEADERS} SHARDS ${ARG_SHARDS})
  endif()
endfunction()
