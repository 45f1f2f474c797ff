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
