# SPDX-License-Identifier: BSD-3-Clause
"""Poses, covariances and the transforms of tf, as arrays. T_a_b maps coordinates of frame b into frame a."""
import bisect

import numpy as np


def pose_matrix(position, quaternion):
    """(4, 4). quaternion: x y z w, of any length. Raises ValueError if it is no rotation."""
    q = np.asarray(quaternion, float)
    length = np.linalg.norm(q)
    if not (np.isfinite(length) and length > 0 and np.all(np.isfinite(position))):
        raise ValueError("no pose: a number is infinite, or the quaternion is zero")
    x, y, z, w = q / length
    T = np.eye(4)
    T[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    T[:3, 3] = position
    return T


def quaternion_of(R):
    """x y z w: the eigenvector of the largest eigenvalue (Bar-Itzhack 2000)."""
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0], [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]])
    return [float(c) for c in np.linalg.eigh(K)[1][:, 3]]  # eigh reads the lower triangle


def planar(T):
    """The pose (4, 4) on the plane z = 0: position and heading of the x axis."""
    yaw = np.arctan2(T[1, 0], T[0, 0])
    return pose_matrix([T[0, 3], T[1, 3], 0], [0, 0, np.sin(yaw / 2), np.cos(yaw / 2)])


def exchanged(P):
    """The covariance (6, 6) with its blocks exchanged: rotation first in facetloc, position first in ROS."""
    order = [3, 4, 5, 0, 1, 2]
    return np.asarray(P, float).reshape(6, 6)[np.ix_(order, order)]


def moved(P, lever):
    """The covariance (6, 6), rotation first, of another point of the same body. lever: from the old point to the new one, in the axes of
    the world, along which the errors are."""
    x, y, z = lever
    J = np.eye(6)
    J[3:, :3] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]  # an error of the rotation moves the point: phi x lever
    return J @ P @ J.T


def symmetric(upper):
    """(6, 6) of its upper triangle by rows."""
    P = np.zeros((6, 6))
    P[np.triu_indices(6)] = upper
    return P + np.triu(P, 1).T


class Frames:
    """The tree of tf: what its messages say, at any time in the last seconds."""
    SECONDS = 10

    def __init__(self):
        self._edges = {}  # child: (parent, stamps, poses in the parent); one stamp, None, if it never changes

    def add(self, parent, child, stamp, T_parent_child):
        """stamp: [s], None for a static transform."""
        known = self._edges.get(child)
        if stamp is None or known is None or known[0] != parent or known[1] == [None]:
            self._edges[child] = (parent, [stamp], [T_parent_child])
            return
        _, stamps, poses = known
        later = bisect.bisect_left(stamps, stamp)  # a bag that begins anew goes back in time
        old = bisect.bisect_left(stamps, stamp - self.SECONDS)
        stamps[later:], poses[later:] = [stamp], [T_parent_child]
        del stamps[:old], poses[:old]

    def _chain(self, frame):
        chain = [frame]
        while chain[-1] in self._edges and self._edges[chain[-1]][0] not in chain:
            chain.append(self._edges[chain[-1]][0])
        return chain

    def _steps(self, a, b):
        """The frames between a, and b, and the one that they have in common; None if there is none."""
        up_a, up_b = self._chain(a), self._chain(b)
        common = next((frame for frame in up_a if frame in up_b), None)
        return None if common is None else (up_a[:up_a.index(common)], up_b[:up_b.index(common)])

    def _at(self, child, stamp):
        _, stamps, poses = self._edges[child]
        if stamps == [None]:
            return poses[0]
        after = bisect.bisect_left(stamps, stamp)
        if after == len(stamps) or (after == 0 and stamps[0] != stamp):
            return None
        if stamps[after] == stamp:
            return poses[after]
        share = (stamp - stamps[after - 1]) / (stamps[after] - stamps[after - 1])
        before, then = poses[after - 1], poses[after]
        p, q = np.array(quaternion_of(before[:3, :3])), np.array(quaternion_of(then[:3, :3]))
        q = q if p @ q >= 0 else -q
        return pose_matrix((1 - share) * before[:3, 3] + share * then[:3, 3], (1 - share) * p + share * q)

    def transform(self, a, b, stamp):
        """T_a_b, or None if tf does not lead from one to the other at that time."""
        steps = self._steps(a, b)
        if steps is None:
            return None
        T = [np.eye(4), np.eye(4)]
        for side, chain in enumerate(steps):
            for frame in chain:
                step = self._at(frame, stamp)
                if step is None:
                    return None
                T[side] = step @ T[side]
        return np.linalg.inv(T[0]) @ T[1]

    def newest(self, a, b):
        """The last time [s] at which T_a_b is known, or None if it is not, or never changes."""
        steps = self._steps(a, b)
        stamps = [self._edges[frame][1][-1] for chain in steps or () for frame in chain]
        return min((s for s in stamps if s is not None), default=None)
