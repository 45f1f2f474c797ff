# SPDX-License-Identifier: BSD-3-Clause
"""ros2 launch facetloc_ros localization.launch.py map:=$HOME/office.flmap depth:=/camera/depth/image_rect_raw"""
import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {"map": ("", "map of facetloc_map, .flmap"),
             "depth": ("/camera/depth/image_rect_raw", "topic of the depth images"),
             "camera_info": ("/camera/depth/camera_info", "topic of their camera_info"),
             "use_sim_time": ("false", "time of /clock"),
             "params_file": (None, "parameters, as in config/localization.yaml")}


def generate_launch_description():
    parameters = os.path.join(get_package_share_directory("facetloc_ros"), "config", "localization.yaml")
    value = {name: LaunchConfiguration(name) for name in ARGUMENTS}
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=parameters if default is None else default, description=what)
          for name, (default, what) in ARGUMENTS.items()),
        Node(package="facetloc_ros", executable="localization", name="facetloc", output="screen",
             parameters=[value["params_file"], {"map": value["map"], "use_sim_time": value["use_sim_time"]}],
             remappings=[("depth", value["depth"]), ("camera_info", value["camera_info"])])])
