# What is installed beside libraries, headers and tools: documents, manual pages, a pkg-config file; and a Debian package of
# all of it (cpack --config CPackConfig.cmake).
install(FILES README.md CHANGELOG.md LICENSE apps/RECORDINGS.md apps/ROBOT.md apps/stream.schema.json apps/odometry.schema.json apps/pose.schema.json apps/frame.schema.json
        features/SENSORS.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
foreach(module features segmentation registration registration/localization registration/mapping)
  install(FILES ${module}/METHOD.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/${module})
endforeach()
install(DIRECTORY apps/examples DESTINATION ${CMAKE_INSTALL_DOCDIR})

# Static libraries need more than a line of flags: they are for CMake.
if(BUILD_SHARED_LIBS)
  set(pc_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  file(RELATIVE_PATH FACETLOC_PREFIX_FROM_PC /${pc_dir} /)
  string(REGEX REPLACE "/$" "" FACETLOC_PREFIX_FROM_PC ${FACETLOC_PREFIX_FROM_PC})
  set(FACETLOC_PC_LIBS "-lfacetloc_mapping -lfacetloc_localization -lfacetloc_registration -lfacetloc_segmentation -lfacetloc_io -lfacetloc_simulation -lfacetloc_features")
  configure_file(${PROJECT_SOURCE_DIR}/cmake/facetloc.pc.in ${PROJECT_BINARY_DIR}/facetloc.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/facetloc.pc DESTINATION ${pc_dir})
endif()

# Manual pages say what --help says.
find_program(HELP2MAN_EXECUTABLE help2man)
if(FACETLOC_BUILD_APPS AND HELP2MAN_EXECUTABLE)
  set(pages "")
  # facetloc_manual(<tool> <what it does> [<its command>])
  function(facetloc_manual tool what)
    string(JOIN - page ${tool} ${ARGN})
    string(JOIN " " call $<TARGET_FILE:${tool}> ${ARGN})
    set(file ${PROJECT_BINARY_DIR}/man/${page}.1)
    add_custom_command(OUTPUT ${file}
      COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/man
      COMMAND ${HELP2MAN_EXECUTABLE} --no-info --version-string ${PROJECT_VERSION} --name ${what} --output ${file} ${call}
      DEPENDS ${tool} COMMENT "Manual page ${page}(1)" VERBATIM)
    set(pages ${pages} ${file} PARENT_SCOPE)
  endfunction()
  facetloc_manual(facetloc_check "what a recording of a depth camera is")
  facetloc_manual(facetloc_convert "a recording of any layout as a folder")
  facetloc_manual(facetloc_segment "depth images to planar surface segments")
  facetloc_manual(facetloc_register "the pose of one depth image relative to another")
  facetloc_manual(facetloc_map "maps of planar surface segments")
  facetloc_manual(facetloc_map "a map of one run of depth images" build)
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
  add_custom_target(manuals ALL DEPENDS ${pages})
  install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The facetloc developers <facetloc@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/features ${PROJECT_BINARY_DIR}/segmentation
    ${PROJECT_BINARY_DIR}/registration ${PROJECT_BINARY_DIR}/registration/localization ${PROJECT_BINARY_DIR}/registration/mapping
    ${PROJECT_BINARY_DIR}/io ${PROJECT_BINARY_DIR}/io/simulation)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)  # and with them what makes the linker see new libraries
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "xvfb, xauth")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libpcl-dev")  # to compile programs with it
include(CPack)
