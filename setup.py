# SPDX-License-Identifier: BSD-3-Clause
"""The wheel, for pip: Python package and tools by CMake, without VTK and MPI, with the libraries that a bare system lacks.

CMake gets the arguments of CMAKE_ARGS, and heeds its own variables (CMAKE_GENERATOR, CMAKE_CXX_COMPILER_LAUNCHER, ...)."""
import os
import pathlib
import platform
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

SOURCE = pathlib.Path(__file__).resolve().parent
# Of every Linux of this glibc or a later one (PEP 600). All others are taken along.
SYSTEM = {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1", "libgcc_s.so.1", "libstdc++.so.6"}


class CMakeBuild(build_ext):
    """Programs in facetloc/bin and libraries in facetloc/lib, each found from where the other is."""

    def run(self):
        build, prefix = SOURCE / "build-wheel", pathlib.Path(self.build_lib).resolve()
        package = prefix / "facetloc"
        defines = {"CMAKE_BUILD_TYPE": "Release", "FACETLOC_WITH_VTK": "OFF", "FACETLOC_WITH_MPI": "OFF", "FACETLOC_BUILD_TESTS": "OFF",
                   "FACETLOC_BUILD_PYTHON": "ON", "FACETLOC_PYTHON": sys.executable, "FACETLOC_PYTHON_DIR": ".",
                   "CMAKE_INSTALL_BINDIR": "facetloc/bin", "CMAKE_INSTALL_LIBDIR": "facetloc/lib",
                   "CMAKE_INSTALL_DATADIR": "facetloc/share"}
        # DT_RPATH, since DT_RUNPATH would not reach what libraries of others need.
        defines.update({f"CMAKE_{kind}_LINKER_FLAGS": "-Wl,--disable-new-dtags" for kind in ("EXE", "SHARED", "MODULE")})
        subprocess.run(["cmake", "-S", SOURCE, "-B", build, *(f"-D{key}={value}" for key, value in defines.items()),
                        *shlex.split(os.environ.get("CMAKE_ARGS", ""))], check=True)
        subprocess.run(["cmake", "--build", build, "--parallel", os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))],
                       check=True)
        for component in ("library", "tools", "python"):
            subprocess.run(["cmake", "--install", build, "--strip", "--prefix", prefix, "--component", component], check=True)
        shutil.copy(SOURCE / "apps/python/wheel/_tools.py", package)
        take_libraries(package)


def take_libraries(package):
    """What the programs and libraries of a package load, beside ours, with the licences of their packages."""
    for link in [path for path in (package / "lib").iterdir() if path.is_symlink()]:  # which a wheel cannot hold
        os.replace(link.resolve(), link)
    ours = [*(package / "bin").iterdir(), *(package / "lib").glob("*.so.*"), *package.glob("*.so")]
    loaded = subprocess.run(["ldd", *ours], check=True, text=True, stdout=subprocess.PIPE).stdout
    if "not found" in loaded:
        sys.exit("a library of the wheel is missing:\n" + loaded)
    for name, path in set(re.findall(r"(\S+) => (/\S+)", loaded)):
        if name in SYSTEM or (package / "lib" / name).exists():
            continue
        shutil.copy(path, package / "lib" / name)
        real = os.path.realpath(path)  # dpkg may know a file below / or below /usr
        of = subprocess.run(["dpkg", "-S", real, real.removeprefix("/usr")], check=False, text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.DEVNULL).stdout.split(":")[0]
        if of:
            (package / "lib/licences").mkdir(exist_ok=True)
            shutil.copy(f"/usr/share/doc/{of}/copyright", package / "lib/licences" / of)


setup(version=re.search(r"project\(facetloc VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8"))[1],
      ext_modules=[Extension("facetloc._facetloc", [])], cmdclass={"build_ext": CMakeBuild},
      options={"bdist_wheel": {"plat_name": "manylinux_" + platform.libc_ver()[1].replace(".", "_") + "_" + platform.machine()}})
