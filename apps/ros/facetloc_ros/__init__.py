# SPDX-License-Identifier: BSD-3-Clause
"""facetloc as a node of ROS 1 or ROS 2."""
