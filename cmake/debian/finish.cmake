# Before a package is closed: manual pages and changelogs are packed, and libraries are found where the system looks for them.
file(GLOB_RECURSE pages ${CPACK_TEMPORARY_DIRECTORY}/facetloc*.1 ${CPACK_TEMPORARY_DIRECTORY}/changelog.Debian)
foreach(page IN LISTS pages)
  execute_process(COMMAND gzip -9 -n -f ${page} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
file(GLOB_RECURSE programs ${CPACK_TEMPORARY_DIRECTORY}/facetloc_* ${CPACK_TEMPORARY_DIRECTORY}/*.so
     ${CPACK_TEMPORARY_DIRECTORY}/*.so.*)
foreach(program IN LISTS programs)
  # The live tool has a folder of drivers of its own.
  if(program MATCHES "/bin/|[.]so" AND NOT IS_SYMLINK ${program} AND NOT program MATCHES "facetloc_live$")
    file(RPATH_REMOVE FILE ${program})
  endif()
endforeach()
