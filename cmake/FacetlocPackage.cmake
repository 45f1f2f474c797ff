# What is installed beside libraries, headers and tools: documents, manual pages, a pkg-config file; and the Debian packages
# (cpack --config CPackConfig.cmake), one for each component: library, dev, tools, tools-gui, python.

# Documents are installed as they lie here, so that the links between them work: DOCDIR/README.md, DOCDIR/apps/ROBOT.md, ...
file(GLOB_RECURSE documents RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS
     ${PROJECT_SOURCE_DIR}/features/*.md ${PROJECT_SOURCE_DIR}/segmentation/*.md ${PROJECT_SOURCE_DIR}/registration/*.md
     ${PROJECT_SOURCE_DIR}/io/*.md ${PROJECT_SOURCE_DIR}/apps/*.md ${PROJECT_SOURCE_DIR}/apps/*.schema.json
     ${PROJECT_SOURCE_DIR}/apps/pictures/*.png ${PROJECT_SOURCE_DIR}/test/*.md
     ${PROJECT_SOURCE_DIR}/features/pictures/*.svg ${PROJECT_SOURCE_DIR}/segmentation/pictures/*.svg ${PROJECT_SOURCE_DIR}/registration/*.svg)
list(FILTER documents EXCLUDE REGEX "^apps/(examples|ros)/")
foreach(document README.md LIMITS.md CHANGELOG.md CONTRIBUTING.md LICENSE apps/presets/paper.ini test/benchmark/large_maps.csv ${documents})
  get_filename_component(folder ${document} DIRECTORY)
  install(FILES ${PROJECT_SOURCE_DIR}/${document} DESTINATION ${CMAKE_INSTALL_DOCDIR}/${folder} COMPONENT dev)
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/apps/examples ${PROJECT_SOURCE_DIR}/apps/ros DESTINATION ${CMAKE_INSTALL_DOCDIR}/apps COMPONENT dev USE_SOURCE_PERMISSIONS)

# Static libraries need more than a line of flags: they are for CMake.
if(BUILD_SHARED_LIBS)
  set(pc_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  file(RELATIVE_PATH FACETLOC_PREFIX_FROM_PC /${pc_dir} /)
  string(REGEX REPLACE "/$" "" FACETLOC_PREFIX_FROM_PC ${FACETLOC_PREFIX_FROM_PC})
  set(FACETLOC_PC_LIBS "-lfacetloc_mapping -lfacetloc_localization -lfacetloc_registration -lfacetloc_segmentation -lfacetloc_openni -lfacetloc_io -lfacetloc_simulation -lfacetloc_features")
  configure_file(${PROJECT_SOURCE_DIR}/cmake/facetloc.pc.in ${PROJECT_BINARY_DIR}/facetloc.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/facetloc.pc DESTINATION ${pc_dir} COMPONENT dev)
endif()

# Manual pages and completion follow from what the tools list about themselves.
find_program(BASH_EXECUTABLE bash)
find_program(HELP2MAN_EXECUTABLE help2man)
if(FACETLOC_BUILD_APPS AND BASH_EXECUTABLE)
  set(tools facetloc_check facetloc_convert facetloc_segment facetloc_register facetloc_map facetloc_localize facetloc_simulate)
  list(TRANSFORM FACETLOC_GUI_TOOLS REPLACE facetloc_front facetloc OUTPUT_VARIABLE gui_names)
  set(listed_by ${tools} ${FACETLOC_GUI_TOOLS} facetloc_front)

  # facetloc_manuals(<component> <tool>...): a page for each tool and each of its commands.
  function(facetloc_manuals component)
    set(pages ${PROJECT_BINARY_DIR}/man/${component})
    add_custom_command(OUTPUT ${pages}.made
      COMMAND ${BASH_EXECUTABLE} ${PROJECT_SOURCE_DIR}/cmake/manuals.sh $<TARGET_FILE_DIR:facetloc_map> ${pages} ${PROJECT_VERSION} ${ARGN}
      COMMAND ${CMAKE_COMMAND} -E touch ${pages}.made
      DEPENDS ${listed_by} ${PROJECT_SOURCE_DIR}/cmake/manuals.sh ${PROJECT_SOURCE_DIR}/cmake/manual.h2m
      COMMENT "Manual pages of ${component}" VERBATIM)
    add_custom_target(manuals-${component} ALL DEPENDS ${pages}.made)
    install(DIRECTORY ${pages}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component})
  endfunction()
  if(HELP2MAN_EXECUTABLE AND gui_names)
    facetloc_manuals(tools ${tools})
    facetloc_manuals(tools-gui ${gui_names})
  elseif(HELP2MAN_EXECUTABLE)
    facetloc_manuals(tools ${tools} facetloc)
  endif()

  set(completions ${PROJECT_BINARY_DIR}/completions)
  list(TRANSFORM tools PREPEND ${completions}/bash/ OUTPUT_VARIABLE of_tools)
  list(TRANSFORM gui_names PREPEND ${completions}/bash/ OUTPUT_VARIABLE of_gui_tools)
  add_custom_command(OUTPUT ${of_tools} ${of_gui_tools} ${completions}/zsh/_facetloc
    COMMAND ${BASH_EXECUTABLE} ${PROJECT_SOURCE_DIR}/cmake/completions.sh $<TARGET_FILE_DIR:facetloc_map> ${completions}
    DEPENDS ${listed_by} ${PROJECT_SOURCE_DIR}/cmake/completions.sh
    COMMENT "Completion of options" VERBATIM)
  add_custom_target(completions ALL DEPENDS ${of_tools} ${of_gui_tools} ${completions}/zsh/_facetloc)
  set(folder ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(FILES ${of_tools} DESTINATION ${folder} COMPONENT tools)
  install(FILES ${of_gui_tools} DESTINATION ${folder} COMPONENT tools-gui)
  install(FILES ${completions}/zsh/_facetloc DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT tools)
endif()

include(FacetlocDebian)
