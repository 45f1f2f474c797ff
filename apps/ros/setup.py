# SPDX-License-Identifier: BSD-3-Clause
from glob import glob

from setuptools import setup

name = "facetloc_ros"
setup(name=name, version="0.4.0", packages=[name], scripts=["scripts/localization"],
      description="Global localization of a depth camera from planar surfaces, in the place of AMCL.", license="BSD-3-Clause",
      maintainer="facetloc", maintainer_email="facetloc@users.noreply.github.com", install_requires=["setuptools"],
      data_files=[("share/ament_index/resource_index/packages", ["resource/" + name]),
                  ("share/" + name, ["package.xml"]),
                  ("share/" + name + "/launch", glob("launch/*")),
                  ("share/" + name + "/config", glob("config/*"))])
