# facetloc_precompile(<target> [REUSE <target>] [<header> ...])
# What nearly all files include is parsed once for all targets with the same flags, not for each file. ccache can only use it with
# CCACHE_SLOPPINESS=pch_defines,time_macros.
function(facetloc_precompile target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "REUSE" "")
  if(NOT FACETLOC_PRECOMPILE)
    return()
  endif()
  if(arg_REUSE)
    target_precompile_headers(${target} REUSE_FROM ${arg_REUSE})
  else()
    target_precompile_headers(${target} PRIVATE
      <Eigen/Cholesky> <Eigen/Core> <Eigen/Geometry> <algorithm> <cmath> <functional> <map> <memory> <optional> <string>
      <vector> ${arg_UNPARSED_ARGUMENTS})
  endif()
  # For ccache; and no garbage collection, a tenth of the time, below 1 GB.
  target_compile_options(${target} PRIVATE "$<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess;--param=ggc-min-heapsize=1048576>")
endfunction()

# facetloc_add_module(<name> SOURCES ... HEADERS ... [DEPENDS <facetloc modules>] [LINK <targets>] [PRIVATE_LINK <targets>]
#                     [PRECOMPILED_AS <facetloc module of the same flags>] [COMPONENT <of packages, library if not given>])
# One library per top-level folder: target facetloc_<name>, alias facetloc::<name>, public headers under
# <name>/include/facetloc/<name>/. Header installation, include directories and the check that each header compiles on
# its own (target all_verify_interface_header_sets) follow from the one HEADERS list.
function(facetloc_add_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "PRECOMPILED_AS;COMPONENT" "SOURCES;HEADERS;DEPENDS;LINK;PRIVATE_LINK")
  set(lib facetloc_${name})
  if(NOT arg_COMPONENT)
    set(arg_COMPONENT library)
  endif()
  add_library(${lib} ${arg_SOURCES})
  add_library(facetloc::${name} ALIAS ${lib})
  if(CMAKE_VERSION VERSION_GREATER_EQUAL 3.23)
    target_sources(${lib} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${arg_HEADERS})
    set(install_headers FILE_SET HEADERS COMPONENT dev)
  else()
    target_include_directories(${lib} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
                                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
    install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)
  endif()
  list(TRANSFORM arg_DEPENDS PREPEND facetloc::)
  target_link_libraries(${lib} PUBLIC ${arg_DEPENDS} ${arg_LINK}
                        PRIVATE fmt::fmt ${arg_PRIVATE_LINK} $<BUILD_INTERFACE:facetloc::base> $<BUILD_INTERFACE:facetloc_warnings>)
  target_include_directories(${lib} PRIVATE src)  # headers that only the module reads, by room
  target_include_directories(${lib} SYSTEM PUBLIC ${PCL_INCLUDE_DIRS})
  target_compile_features(${lib} PUBLIC cxx_std_17)
  # PCL's targets name all of VTK, Qt and MPI.
  target_link_options(${lib} PRIVATE LINKER:--as-needed)
  # No fused multiply-add behind our back: the same input gives the same bytes on every machine.
  target_compile_options(${lib} PRIVATE $<$<CXX_COMPILER_ID:GNU,Clang>:-ffp-contract=off>)
  # Every translation unit that sees PCL clouds has to agree with Debian's SSE2 build, also under -mavx2 and sanitizers.
  target_compile_definitions(${lib} PUBLIC EIGEN_MAX_ALIGN_BYTES=16 EIGEN_MALLOC_ALREADY_ALIGNED=1)
  # RUNPATH is not transitive: libfacetloc_registration.so must find libfacetloc_features.so beside itself.
  set_target_properties(${lib} PROPERTIES
    EXPORT_NAME ${name} VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    POSITION_INDEPENDENT_CODE ON DEFINE_SYMBOL "" VERIFY_INTERFACE_HEADER_SETS ON CXX_EXTENSIONS OFF INSTALL_RPATH "$ORIGIN"
    BUILD_RPATH ${FACETLOC_LOADED_DIR})
  list(TRANSFORM arg_PRECOMPILED_AS PREPEND "REUSE;facetloc_")
  facetloc_precompile(${lib} ${arg_PRECOMPILED_AS})
  install(TARGETS ${lib} EXPORT facetloc-targets
          LIBRARY COMPONENT ${arg_COMPONENT} NAMELINK_COMPONENT dev
          ARCHIVE COMPONENT dev
          ${install_headers})
endfunction()

# facetloc_add_loaded(<name> COMPONENT <of packages> SOURCES ... LINK ...)
# A shared library that another one or a tool loads when it is needed (apps/src/batch/ranks.cpp), by the name
# in FACETLOC_LOADED_<name>: a part with dependencies that not everybody wants to install.
function(facetloc_add_loaded name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "COMPONENT" "SOURCES;LINK")
  set(lib facetloc_${name})
  add_library(${lib} SHARED ${arg_SOURCES})
  target_compile_features(${lib} PRIVATE cxx_std_17)
  target_link_libraries(${lib} PRIVATE ${arg_LINK} facetloc_warnings)
  target_link_options(${lib} PRIVATE LINKER:--as-needed)
  set(version ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  set_target_properties(${lib} PROPERTIES
    VERSION ${PROJECT_VERSION} SOVERSION ${version} CXX_EXTENSIONS OFF LIBRARY_OUTPUT_DIRECTORY ${FACETLOC_LOADED_DIR} INSTALL_RPATH "$ORIGIN")
  install(TARGETS ${lib} LIBRARY COMPONENT ${arg_COMPONENT} NAMELINK_SKIP)
  set(FACETLOC_LOADED_${name} lib${lib}.so.${version} PARENT_SCOPE)
endfunction()
set(FACETLOC_LOADED_DIR ${PROJECT_BINARY_DIR}/loaded)

add_library(facetloc_warnings INTERFACE)
target_compile_options(facetloc_warnings INTERFACE
  $<$<CXX_COMPILER_ID:GNU,Clang>:-Wall;-Wextra;-Wpedantic;-Wshadow;-Wno-sign-conversion>
  $<$<CXX_COMPILER_ID:Clang>:-Wno-gnu-anonymous-struct;-Wno-nested-anon-types>  # PCL_ADD_POINT4D has both
  $<$<BOOL:${FACETLOC_WERROR}>:-Werror>)

function(facetloc_install_package)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "COMPONENTS")
  include(CMakePackageConfigHelpers)
  set(FACETLOC_COMPONENTS ${arg_COMPONENTS})
  set(dir ${CMAKE_INSTALL_LIBDIR}/cmake/facetloc)
  install(EXPORT facetloc-targets NAMESPACE facetloc:: DESTINATION ${dir} COMPONENT dev)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/facetloc-config.cmake.in
    ${PROJECT_BINARY_DIR}/facetloc-config.cmake INSTALL_DESTINATION ${dir})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/facetloc-config-version.cmake
    COMPATIBILITY SameMajorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/facetloc-config.cmake ${PROJECT_BINARY_DIR}/facetloc-config-version.cmake
          DESTINATION ${dir} COMPONENT dev)
endfunction()
