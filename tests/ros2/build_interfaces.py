"""Builds our msgs/ and simulation_interfaces into this virtual environment, as colcon would: cmake and the rosidl generators of real ROS.

    target/ros2/DISTRO/bin/python tests/ros2/build_interfaces.py
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig

import numpy

HERE = pathlib.Path(__file__).resolve().parent
VENV = pathlib.Path(sys.prefix)
PACKAGE_XML = """<package format="3"><name>{name}</name><version>2.1.0</version><description>-</description>
<maintainer email="nobody@example.com">-</maintainer><license>Apache-2.0</license>
<buildtool_depend>ament_cmake</buildtool_depend><buildtool_depend>rosidl_default_generators</buildtool_depend>
<depend>builtin_interfaces</depend><depend>geometry_msgs</depend><depend>std_msgs</depend><depend>action_msgs</depend>
<member_of_group>rosidl_interface_packages</member_of_group></package>"""
CMAKE = """cmake_minimum_required(VERSION 3.16)
project({name})
find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
find_package(geometry_msgs REQUIRED)
find_package(std_msgs REQUIRED)
find_package(action_msgs REQUIRED)
file(GLOB files RELATIVE ${{CMAKE_CURRENT_SOURCE_DIR}} msg/*.msg srv/*.srv action/*.action)
rosidl_generate_interfaces(${{PROJECT_NAME}} ${{files}} DEPENDENCIES geometry_msgs std_msgs action_msgs)
ament_package()
"""


def point_to_this_python():
    """The wheels were made elsewhere: their CMake files name the Python and the numpy of that machine."""
    ours = {
        r"/opt/python/cp\d+-cp\d+/include/python3\.\d+": sysconfig.get_paths()["include"],
        r"/opt/python/cp\d+-cp\d+/lib/python3\.\d+/site-packages/numpy/_core/include": numpy.get_include(),
    }
    for path in VENV.glob("share/*/cmake/*.cmake"):
        text = path.read_text()
        new = text
        for pattern, to in ours.items():
            new = re.sub(pattern, to, new)
        if new != text:
            path.write_text(new)


def unpack(listing, to):
    """Writes the package whose files stand one after another in `listing`."""
    shutil.rmtree(to, ignore_errors=True)
    for part in listing.read_text().split("== ")[1:]:
        name, body = part.split("\n", 1)
        path = to / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(body)
    (to / "package.xml").write_text(PACKAGE_XML.format(name=to.name))
    (to / "CMakeLists.txt").write_text(CMAKE.format(name=to.name))


def build(source, name):
    folder = VENV / "build" / name
    site = sysconfig.get_paths()["purelib"]
    env = dict(os.environ, AMENT_PREFIX_PATH=str(VENV), PYTHONPATH=site, LD_LIBRARY_PATH=str(VENV / "lib"), PATH=f"{VENV}/bin:{os.environ['PATH']}")
    cmake = VENV / "bin" / "cmake"
    configure = [cmake, "-S", source, "-B", folder, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={VENV}", f"-DCMAKE_INSTALL_PREFIX={VENV}"]
    # Without a build type nothing is optimised: that takes the compiler less time.
    configure += [f"-DPython3_EXECUTABLE={VENV}/bin/python", "-DBUILD_TESTING=OFF", "-DCMAKE_BUILD_TYPE=", "-Wno-dev"]
    for command in (configure, [cmake, "--build", folder, "--target", "install"]):
        done = subprocess.run(list(map(str, command)), env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            sys.exit(f"building {name} failed:\n{done.stdout[-4000:]}")


def main():
    point_to_this_python()
    copy = VENV / "src" / "simulation_interfaces"
    unpack(HERE / "interfaces" / "simulation_interfaces.txt", copy)
    for source, name in ((HERE.parent.parent / "msgs", "matpoint_msgs"), (copy, "simulation_interfaces")):
        build(source, name)
        print(f"built {name}")


if __name__ == "__main__":
    main()
