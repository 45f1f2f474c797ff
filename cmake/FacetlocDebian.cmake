# The Debian packages by CPack: libfacetloc0.3, libfacetloc-vtk, libfacetloc-dev, facetloc-tools, facetloc-tools-mpi,
# facetloc-tools-gui, python3-facetloc.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The facetloc developers <facetloc@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SOURCE facetloc)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/features ${PROJECT_BINARY_DIR}/segmentation
    ${PROJECT_BINARY_DIR}/registration ${PROJECT_BINARY_DIR}/registration/localization ${PROJECT_BINARY_DIR}/registration/mapping
    ${PROJECT_BINARY_DIR}/io ${PROJECT_BINARY_DIR}/io/simulation ${PROJECT_BINARY_DIR}/io/openni ${FACETLOC_LOADED_DIR})
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/debian/finish.cmake)
set(CPACK_COMPONENTS_ALL "")

string(TIMESTAMP FACETLOC_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
configure_file(${PROJECT_SOURCE_DIR}/cmake/debian/changelog.in ${PROJECT_BINARY_DIR}/debian/changelog.Debian @ONLY)

# facetloc_package(<component> <package> <section> <summary> <description> [DEPENDS <components>] [NEEDS <packages>] [RECOMMENDS <packages>])
# The copyright and the changelog of a package are installed with its component alone.
function(facetloc_package component package section summary description)
  cmake_parse_arguments(PARSE_ARGV 5 arg "" "NEEDS;RECOMMENDS" "DEPENDS")
  string(TOUPPER ${component} c)
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_NAME ${package} PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_DESCRIPTION "${summary}\n${description}" PARENT_SCOPE)
  set(CPACK_COMPONENT_${c}_DESCRIPTION "${summary}\n${description}" PARENT_SCOPE)
  set(CPACK_COMPONENT_${c}_DEPENDS ${arg_DEPENDS} PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_DEPENDS "${arg_NEEDS}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_RECOMMENDS "${arg_RECOMMENDS}" PARENT_SCOPE)
  set(docs ${CMAKE_INSTALL_DATADIR}/doc/${package})
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/debian/copyright DESTINATION ${docs} COMPONENT ${component} EXCLUDE_FROM_ALL)
  install(FILES ${PROJECT_BINARY_DIR}/debian/changelog.Debian DESTINATION ${docs} COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()

set(what "facetloc finds where a depth camera is, with nothing but the geometry of
planes: it segments a depth image into planar surface segments, matches them
to a map and returns a ranked list of poses with covariance and probability.
.
")
set(soname ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
facetloc_package(library libfacetloc${soname} libs "global localization of a depth camera by planes"
  "${what}This package has the shared libraries, and the driver of OpenNI2 that
plays recordings as a camera.")
facetloc_package(vtk libfacetloc-vtk libs "global localization of a depth camera by planes - with VTK"
  "${what}This package has the part that needs VTK: cameras by PCL and OpenNI2."
  DEPENDS library)
facetloc_package(dev libfacetloc-dev libdevel "global localization of a depth camera by planes - development"
  "${what}This package has headers, CMake and pkg-config files, documents and
examples."
  DEPENDS library vtk NEEDS "libpcl-dev, libopenni2-dev, libeigen3-dev")
if(FACETLOC_BUILD_APPS)
  facetloc_package(tools facetloc-tools science "global localization of a depth camera by planes - tools"
    "${what}This package has the tools that make maps of recordings and localize
images in them."
    DEPENDS library)
  if(FACETLOC_WITH_MPI)
    facetloc_package(tools-mpi facetloc-tools-mpi science "global localization of a depth camera by planes - MPI"
      "${what}This package lets mpirun deal out the work of the tools to processes
and machines."
      DEPENDS library tools NEEDS "openmpi-bin")
  endif()
  facetloc_package(tools-gui facetloc-tools-gui science "global localization of a depth camera by planes - live"
    "${what}This package has the tools with windows, charts and pictures: the live
one, evaluation and rendering."
    DEPENDS library vtk tools RECOMMENDS "xvfb, xauth")
endif()
if(FACETLOC_BUILD_APPS AND FACETLOC_BUILD_PYTHON)
  facetloc_package(python python3-facetloc python "global localization of a depth camera by planes - Python 3"
    "${what}This package has the Python module facetloc."
    DEPENDS library NEEDS "python3 (>= 3.11), python3 (<< 3.12), python3-numpy" RECOMMENDS "python3-matplotlib")
endif()
# Which package has a library, for others that link it, and that the linker is to look for new ones.
set(shlibs "")
foreach(lib features segmentation registration localization mapping io simulation)
  string(APPEND shlibs "libfacetloc_${lib} ${soname} libfacetloc${soname} (>= ${PROJECT_VERSION})\n")
endforeach()
file(CONFIGURE OUTPUT debian/shlibs CONTENT "${shlibs}")
file(CONFIGURE OUTPUT debian/triggers CONTENT "activate-noawait ldconfig\n")
file(CONFIGURE OUTPUT debian/vtk/shlibs CONTENT "libfacetloc_openni ${soname} libfacetloc-vtk (>= ${PROJECT_VERSION})\n")
set(CPACK_DEBIAN_VTK_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/vtk/shlibs ${PROJECT_BINARY_DIR}/debian/triggers)
file(CONFIGURE OUTPUT debian/mpi/shlibs CONTENT "libfacetloc_mpi ${soname} facetloc-tools-mpi (>= ${PROJECT_VERSION})\n")
set(CPACK_DEBIAN_TOOLS-MPI_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/mpi/shlibs ${PROJECT_BINARY_DIR}/debian/triggers)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/shlibs ${PROJECT_BINARY_DIR}/debian/triggers)
include(CPack)
