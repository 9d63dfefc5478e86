# The panel in the binary: what scripts/panel.sh has left in build/panel becomes the list that
# server/web/web_assets.h declares, each file compressed, with its type and a hash. Looked at in every
# build; an empty list where there is no panel.

set(SINEW_PANEL_SCRIPT "${CMAKE_CURRENT_LIST_DIR}/panel_assets.cmake")

function(sinew_panel_assets target)
  set(source "${CMAKE_BINARY_DIR}/panel/web_assets.cc")
  add_custom_target(${target}_panel
    COMMAND "${CMAKE_COMMAND}" "-DPANEL=${CMAKE_SOURCE_DIR}/build/panel" "-DSOURCE=${source}"
      -P "${SINEW_PANEL_SCRIPT}"
    BYPRODUCTS "${source}" COMMENT "" VERBATIM)
  target_sources(${target} PRIVATE "${source}")
  sinew_alone("${source}")
  set_source_files_properties("${source}" PROPERTIES GENERATED TRUE)
  add_dependencies(${target} ${target}_panel)
endfunction()
