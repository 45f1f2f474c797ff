# Target doc: the public headers by Doxygen, grouped by module, in doc/html of the build. A warning is an error.
find_program(DOXYGEN_EXECUTABLE doxygen)
if(DOXYGEN_EXECUTABLE)
  set(modules features segmentation registration registration/localization registration/mapping io io/simulation)
  list(TRANSFORM modules PREPEND ${PROJECT_SOURCE_DIR}/ OUTPUT_VARIABLE headers)
  list(TRANSFORM headers APPEND /include)
  list(JOIN headers "\" \"" headers)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/Doxyfile.in ${PROJECT_BINARY_DIR}/doc/Doxyfile @ONLY)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/doxygen_groups.dox.in ${PROJECT_BINARY_DIR}/doc/groups.dox @ONLY)
  add_custom_target(doc ${DOXYGEN_EXECUTABLE} ${PROJECT_BINARY_DIR}/doc/Doxyfile
                    COMMENT "Documentation of the public headers: ${PROJECT_BINARY_DIR}/doc/html/index.html" VERBATIM)
else()
  add_custom_target(doc COMMAND ${CMAKE_COMMAND} -E echo "The documentation needs doxygen" COMMAND ${CMAKE_COMMAND} -E false VERBATIM)
endif()

# Target site: the documents as pages with a search, in site/html of the build. A link that leads nowhere is an error.
find_program(MKDOCS_EXECUTABLE mkdocs)
if(MKDOCS_EXECUTABLE)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/mkdocs.yml.in ${PROJECT_BINARY_DIR}/site/mkdocs.yml @ONLY)
  add_custom_target(site ${CMAKE_COMMAND} -D DOCUMENTS=${PROJECT_BINARY_DIR}/site/docs -P ${PROJECT_SOURCE_DIR}/cmake/documents.cmake
                    COMMAND ${MKDOCS_EXECUTABLE} build --strict --quiet -f ${PROJECT_BINARY_DIR}/site/mkdocs.yml
                    COMMENT "The documents as pages: ${PROJECT_BINARY_DIR}/site/html/index.html" VERBATIM)
else()
  add_custom_target(site COMMAND ${CMAKE_COMMAND} -E echo "The site needs mkdocs and mkdocs-material" COMMAND ${CMAKE_COMMAND} -E false
                    VERBATIM)
endif()
