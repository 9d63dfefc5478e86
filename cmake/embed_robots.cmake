# Run with -P: writes the robots' FILES, byte for byte, into OUTPUT as the table that
# sinew/config/builtin_robots.h declares.
set(arrays "")
set(rows "")
set(index 0)
foreach(file IN LISTS FILES)
  get_filename_component(id "${file}" NAME_WE)
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" bytes HEX)
  string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND arrays "constexpr char kText${index}[] = {${bytes}'\\0'};\n")
  string(APPEND rows
    "    {\"${id}\", \"robots/${name}\", {kText${index}, sizeof(kText${index}) - 1}},\n")
  math(EXPR index "${index} + 1")
endforeach()

file(WRITE "${OUTPUT}" "// Written by cmake/embed_robots.cmake; edit robots/*.toml instead.
#include \"sinew/config/builtin_robots.h\"

namespace sinew {
namespace {

${arrays}
constexpr BuiltinRobot kRobots[] = {
${rows}};

}  // namespace

std::span<const BuiltinRobot> builtin_robots() {
  return kRobots;
}

}  // namespace sinew
")
