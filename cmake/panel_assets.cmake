# cmake -DPANEL=folder -DSOURCE=file.cc -P panel_assets.cmake: writes the file where it would change.
cmake_minimum_required(VERSION 3.25)

set(type_html "text/html; charset=utf-8")
set(type_js "text/javascript; charset=utf-8")
set(type_css "text/css; charset=utf-8")
set(type_svg "image/svg+xml")
set(type_woff2 "font/woff2")
set(type_json "application/json")
set(type_png "image/png")

set(files "")
if(EXISTS "${PANEL}/index.html")
  file(GLOB_RECURSE files RELATIVE "${PANEL}" "${PANEL}/*")
  list(SORT files)
endif()

set(print "")
foreach(name IN LISTS files)
  file(SHA256 "${PANEL}/${name}" hash)
  string(APPEND print "${name} ${hash}\n")
endforeach()
string(SHA256 print "${print}")
if(EXISTS "${SOURCE}")
  file(STRINGS "${SOURCE}" first LIMIT_COUNT 1)
  if(first STREQUAL "// ${print}")
    return()
  endif()
endif()

set(arrays "")
set(rows "")
set(count 0)
foreach(name IN LISTS files)
  string(REGEX MATCH "[^.]+$" ending "${name}")
  if(NOT DEFINED type_${ending})
    message(FATAL_ERROR "panel: ${name}: nobody has said which type files *.${ending} have")
  endif()
  file(SHA256 "${PANEL}/${name}" hash)
  string(SUBSTRING "${hash}" 0 16 hash)
  execute_process(COMMAND gzip -9nc "${PANEL}/${name}" OUTPUT_FILE "${SOURCE}.gz"
    COMMAND_ERROR_IS_FATAL ANY)
  file(READ "${SOURCE}.gz" bytes HEX)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  string(APPEND arrays "constexpr std::uint8_t kFile${count}[] = {${bytes}};\n")
  string(APPEND rows
    "    {\"/${name}\", \"${type_${ending}}\", \"\\\"${hash}\\\"\", kFile${count}},\n")
  math(EXPR count "${count} + 1")
endforeach()
file(REMOVE "${SOURCE}.gz")

set(body "  return {};\n")
if(files)
  set(body "  static constexpr Asset kAssets[] = {\n${rows}  };\n  return kAssets;\n")
endif()
file(WRITE "${SOURCE}" "// ${print}
// Written by cmake/panel_assets.cmake.
#include \"sinew/server/web/web_assets.h\"

namespace sinew::server {
namespace {

${arrays}
}  // namespace

std::span<const Asset> web_assets() {
${body}}

}  // namespace sinew::server
")
