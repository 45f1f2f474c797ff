#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Somebody with a PCL pipeline: both programs of README, in a CMake project of their own, on organized clouds."""
import re

from newcomer import Newcomer, check, check_right

PROJECT = """cmake_minimum_required(VERSION 3.24)
{project}
{package}
add_executable(pipeline pipeline.cpp)
target_link_libraries(pipeline {targets})
"""

PROGRAM = """{includes}
#include <pcl/io/pcd_io.h>

#include <cstdio>
#include <filesystem>
#include <iostream>

std::string stamp;

void use(const Eigen::Isometry3d& T, const facetloc::Matrix6d&) {{
  const Eigen::Vector3d t = T.translation();
  const Eigen::Quaterniond q(T.linear());
  std::printf("pose %s %f %f %f %f %f %f %f\\n", stamp.c_str(), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}}

void localizeCloud(const pcl::PointCloud<pcl::PointXYZRGBA>::ConstPtr& cloud) {{
{cloud}
}}

void localizeRecording() {{
{recording}
}}

int main(int argc, char** argv) {{
  for (int i = 1; i < argc; ++i) {{
    stamp = std::filesystem::path(argv[i]).stem().string();
    const pcl::PointCloud<pcl::PointXYZRGBA>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZRGBA>);
    if (pcl::io::loadPCDFile(argv[i], *cloud) != 0) return 1;
    localizeCloud(cloud);
    std::cout << std::endl;
  }}
  std::cout << "recording\\n";
  localizeRecording();
}}
"""


def project(section):
    """The CMake project that the sentence with find_package describes."""
    text = "\n".join(section)
    (package,) = re.findall(r"`(find_package\(facetloc [^`]*\))`", text)
    (project_line,) = re.findall(r"`(project\([^`]*\))`", text)
    targets = re.findall(r"`(facetloc::[a-z]+)`", text)
    return PROJECT.format(project=project_line, package=package, targets=" ".join(targets))


with Newcomer() as user:
    readme, heading = user.document("README.md"), "You have a PCL pipeline"
    blocks = readme.code(heading, "cpp") + user.document("registration/localization/README.md").code("A recording in a map", "cpp")
    check(len(blocks) == 2, "there is a program for clouds and one for depth images")
    includes = sorted(set(re.findall(r"^#include .*$", "\n".join(blocks), re.MULTILINE)))
    cloud, recording = (re.sub(r"^#include .*\n", "", block, flags=re.MULTILINE) for block in blocks)
    source = user.folder / "pipeline"
    source.mkdir()
    (source / "CMakeLists.txt").write_text(project(readme.section(heading)), encoding="utf-8")
    (source / "pipeline.cpp").write_text(PROGRAM.format(includes="\n".join(includes), cloud=cloud, recording=recording), encoding="utf-8")
    user.type(f"cmake -S pipeline -B build -DCMAKE_PREFIX_PATH={user.prefix} && cmake --build build")

    user.make_sample()
    user.type("facetloc_map build walk/map -o walk.flmap")
    user.type("facetloc_segment walk/query -o clouds --pcd")
    truth = user.poses("walk/query/groundtruth.txt")
    printed = user.type("build/pipeline clouds/*[0-9].pcd")
    of_clouds, of_recording = printed.split("recording\n")
    sure = {}
    for line in of_clouds.splitlines():
        if line.startswith("pose "):
            stamp, *numbers = line.removeprefix("pose ").split()
            sure[round(float(re.match(r"[\d.]*\d", stamp)[0]), 3)] = [float(number) for number in numbers]
    check_right(sure, truth, 0.3)
    found = re.findall(r"^(\S+) at (\S+) +(\S+) +(\S+)$", of_recording, re.MULTILINE)
    right = sum(float(p) >= 0.9 for p, *_ in found)
    check(right >= 0.3 * len(truth), f"{right} of {len(truth)} depth images have a pose with a probability of at least 0.9")
