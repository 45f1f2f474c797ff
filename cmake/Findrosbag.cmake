# The libraries that read ROS 1 bags, as Debian 12 has them: rosbag_INCLUDE_DIRS, rosbag_LIBRARIES. Debian's files for
# pkg-config and CMake ask for packages that do not exist there.
set(headers rosbag/bag.h pluginlib/class_loader.hpp class_loader/class_loader.hpp rcpputils/shared_library.hpp
            rcutils/shared_library.h ament_index_cpp/get_package_prefix.hpp)
set(libraries rosbag_storage roscpp_serialization rostime cpp_common)

set(required "")
set(rosbag_INCLUDE_DIRS "")
set(rosbag_LIBRARIES "")
foreach(header IN LISTS headers)
  string(REGEX REPLACE "/.*" "" package ${header})
  find_path(rosbag_${package}_DIR ${header} PATH_SUFFIXES ${package})
  mark_as_advanced(rosbag_${package}_DIR)
  list(APPEND required rosbag_${package}_DIR)
  list(APPEND rosbag_INCLUDE_DIRS ${rosbag_${package}_DIR})
endforeach()
foreach(library IN LISTS libraries)
  find_library(rosbag_${library}_LIBRARY ${library})
  mark_as_advanced(rosbag_${library}_LIBRARY)
  list(APPEND required rosbag_${library}_LIBRARY)
  list(APPEND rosbag_LIBRARIES ${rosbag_${library}_LIBRARY})
endforeach()
list(REMOVE_DUPLICATES rosbag_INCLUDE_DIRS)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(rosbag REQUIRED_VARS ${required}
  REASON_FAILURE_MESSAGE "install librosbag-storage-dev librcpputils-dev libament-index-cpp-dev")
