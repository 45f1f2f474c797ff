# SPDX-License-Identifier: BSD-3-Clause
"""The node of whichever ROS is there."""
from .localization import Localization


def main():
    """Returns the exit code."""
    try:
        from .ros2 import Ros2 as Ros
    except ImportError:
        from .ros1 import Ros1 as Ros
    ros = Ros("facetloc")
    localization = Localization(ros)
    try:
        ros.spin(localization.tick)
    except KeyboardInterrupt:
        pass
    finally:
        code = localization.stop()
    return code
