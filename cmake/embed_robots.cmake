# Run with -P: writes the robots' FILES, byte for byte, into OUTPUT as the table that
# sinew/config/builtin_robots.h declares, and the CELL that cell_file.h declares.
set(arrays "")
set(rows "")
set(index 0)
foreach(file IN LISTS FILES)
  get_filename_component(id "${file}" NAME_WE)
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" bytes HEX)
  string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND arrays "constexpr char kText${index}[] = {${bytes}'\\0'};\n")
  get_filename_component(folder "${file}" DIRECTORY)
  set(program "")
  if(EXISTS "${folder}/${id}/demonstration.sinew")
    file(READ "${folder}/${id}/demonstration.sinew" program HEX)
    string(REGEX REPLACE "(..)" "'\\\\x\\1'," program "${program}")
  endif()
  string(APPEND arrays "constexpr char kShown${index}[] = {${program}'\\0'};\n")
  string(APPEND rows
    "    {\"${id}\", \"robots/${name}\", {kText${index}, sizeof(kText${index}) - 1},\n"
    "     {kShown${index}, sizeof(kShown${index}) - 1}},\n")
  math(EXPR index "${index} + 1")
endforeach()

file(READ "${CELL}" cell HEX)
string(REGEX REPLACE "(..)" "'\\\\x\\1'," cell "${cell}")

file(WRITE "${OUTPUT}" "// Written by cmake/embed_robots.cmake; edit robots/*.toml and cells/ instead.
#include \"sinew/config/builtin_robots.h\"
#include \"sinew/config/cell_file.h\"

namespace sinew {
namespace {

${arrays}
constexpr char kCell[] = {${cell}'\\0'};
constexpr BuiltinRobot kRobots[] = {
${rows}};

}  // namespace

std::span<const BuiltinRobot> builtin_robots() {
  return kRobots;
}

std::string_view builtin_cell() {
  return {kCell, sizeof(kCell) - 1};
}

}  // namespace sinew
")
