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

# Manual pages say what --help says, and which exit codes there are.
find_program(HELP2MAN_EXECUTABLE help2man)
if(FACETLOC_BUILD_APPS AND HELP2MAN_EXECUTABLE)
  set(pages "")
  set(pages_gui "")
  # facetloc_manual(<target> <what it does> [<its command>])
  function(facetloc_manual tool what)
    string(REPLACE facetloc_front facetloc name ${tool})
    string(JOIN - page ${name} ${ARGN})
    string(JOIN " " call $<TARGET_FILE:${tool}> ${ARGN})
    set(file ${PROJECT_BINARY_DIR}/man/${page}.1)
    add_custom_command(OUTPUT ${file}
      COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/man
      COMMAND ${HELP2MAN_EXECUTABLE} --no-info --include ${PROJECT_SOURCE_DIR}/cmake/manual.h2m --version-string ${PROJECT_VERSION} --name ${what} --output ${file} ${call}
      DEPENDS ${tool} ${PROJECT_SOURCE_DIR}/cmake/manual.h2m COMMENT "Manual page ${page}(1)" VERBATIM)
    if(tool IN_LIST FACETLOC_GUI_TOOLS)
      set(pages_gui ${pages_gui} ${file} PARENT_SCOPE)
    else()
      set(pages ${pages} ${file} PARENT_SCOPE)
    endif()
  endfunction()
  facetloc_manual(facetloc_front "where a depth camera is, from the planes that it sees")
  facetloc_manual(facetloc_front "from a recording to a report" try)
  facetloc_manual(facetloc_check "what a recording of a depth camera is")
  facetloc_manual(facetloc_convert "a recording of any layout as a folder")
  facetloc_manual(facetloc_segment "depth images to planar surface segments")
  facetloc_manual(facetloc_register "the pose of one depth image relative to another")
  facetloc_manual(facetloc_map "maps of planar surface segments")
  facetloc_manual(facetloc_map "a map of one run of depth images" build)
  facetloc_manual(facetloc_map "a map of a scan, a mesh or a floor plan" from-model)
  facetloc_manual(facetloc_map "a map brought up to date with a later run" extend)
  facetloc_manual(facetloc_map "views beside the drive of a map" densify)
  facetloc_manual(facetloc_map "the probability from which on answers in a map are sure" calibrate)
  facetloc_manual(facetloc_map "what is in a map" info)
  facetloc_manual(facetloc_map "proves a map sound" check)
  facetloc_manual(facetloc_map "a map for other programs" export)
  facetloc_manual(facetloc_map "poses of a map from another program" import)
  facetloc_manual(facetloc_map "several maps as one" merge)
  facetloc_manual(facetloc_localize "where depth images were taken in a map")
  facetloc_manual(facetloc_evaluate "results judged by what is true")
  facetloc_manual(facetloc_simulate "made-up places and depth sequences")
  facetloc_manual(facetloc_render "pictures of images, maps and results")
  facetloc_manual(facetloc_live "segmentation and localization of a depth camera, live")
  add_custom_target(manuals ALL DEPENDS ${pages} ${pages_gui})
  install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tools)
  install(FILES ${pages_gui} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tools-gui)
endif()

# Completion in bash and zsh, of the options that the tools list.
find_program(BASH_EXECUTABLE bash)
if(FACETLOC_BUILD_APPS AND BASH_EXECUTABLE)
  set(completions ${PROJECT_BINARY_DIR}/completions)
  set(tools facetloc_check facetloc_convert facetloc_segment facetloc_register facetloc_map facetloc_localize facetloc_simulate)
  list(TRANSFORM tools PREPEND ${completions}/bash/ OUTPUT_VARIABLE of_tools)
  list(TRANSFORM FACETLOC_GUI_TOOLS REPLACE facetloc_front facetloc OUTPUT_VARIABLE gui_names)
  list(TRANSFORM gui_names PREPEND ${completions}/bash/ OUTPUT_VARIABLE of_gui_tools)
  add_custom_command(OUTPUT ${of_tools} ${of_gui_tools} ${completions}/zsh/_facetloc
    COMMAND ${BASH_EXECUTABLE} ${PROJECT_SOURCE_DIR}/cmake/completions.sh $<TARGET_FILE_DIR:facetloc_map> ${completions}
    DEPENDS ${tools} ${FACETLOC_GUI_TOOLS} ${PROJECT_SOURCE_DIR}/cmake/completions.sh
    COMMENT "Completion of options" VERBATIM)
  add_custom_target(completions ALL DEPENDS ${of_tools} ${of_gui_tools} ${completions}/zsh/_facetloc)
  set(folder ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(FILES ${of_tools} DESTINATION ${folder} COMPONENT tools)
  install(FILES ${of_gui_tools} DESTINATION ${folder} COMPONENT tools-gui)
  install(FILES ${completions}/zsh/_facetloc DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT tools)
endif()

include(FacetlocDebian)
