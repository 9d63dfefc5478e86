# sinew_embed_robots(<target> <cell> <programs> <file>...): a cell's and the robots' files, and the
# demonstration programs that lie in folders of the robots' names beside them, become part of the
# library, so that an installed program needs no data directory. Touching a file rebuilds the table.
set(SINEW_EMBED_SCRIPT "${CMAKE_CURRENT_LIST_DIR}/embed_robots.cmake")

function(sinew_embed_robots target cell programs)
  set(output "${CMAKE_CURRENT_BINARY_DIR}/builtin_robots.cc")
  add_custom_command(OUTPUT "${output}"
    COMMAND "${CMAKE_COMMAND}" "-DOUTPUT=${output}" "-DCELL=${cell}"
      "-DFILES=${ARGN}" -P "${SINEW_EMBED_SCRIPT}"
    DEPENDS ${cell} ${programs} ${ARGN} "${SINEW_EMBED_SCRIPT}"
    COMMENT "Embedding the robots' files"
    VERBATIM)
  target_sources(${target} PRIVATE "${output}")
  sinew_alone("${output}")
endfunction()
