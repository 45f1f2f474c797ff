# SPDX-License-Identifier: BSD-3-Clause
"""Global localization of a depth camera from planar surface segments.

    import facetloc
    office = facetloc.Map.open("office.flmap")
    localizer = facetloc.Localizer(office)
    walk = facetloc.Recording.open("walk")
    for frame in walk:
        answer = localizer.localize(frame.depth, walk.camera)
        print(answer.state, answer.T_w_c if answer.sure else answer.reason)

Depth images are arrays of (height, width): uint16 by the camera's depth_scale, or float in metres; 0, NaN and infinity are not
measured. Poses T_a_b are arrays of (4, 4) that map coordinates of frame b into frame a: w world, m local model, c camera (x right,
y down, z forward), b robot base. Covariances are (6, 6), rotation first: the true pose is (exp(phi) R, t + dt), with phi and dt in
the axes of frame a [rad, m]. Images are worked on at 320 columns, as the tools do, unless width says otherwise; 0 = full size.

Errors are exceptions with the sentences of the tools: IoError, an OSError, for files and cameras, TypeError and ValueError, which name
the argument, for impossible ones. draw() plots maps and answers, and show() opens the page of a map. Cameras and maps can be copied and
pickled, maps by their path. Nothing holds the lock of the interpreter while it computes."""
from __future__ import annotations

import os
import pathlib
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _facetloc
from ._checks import checked, image, numbers, path as as_path, real, refuse, whole
from ._drawing import Page, draw, show
from ._facetloc import Camera, IoError, __version__

__all__ = ["Answer", "Camera", "Frame", "Hypothesis", "IoError", "LocalModel", "Localizer", "Map", "MapMaking", "NextLook", "Page",
           "Recording", "Registration", "Segment", "Segmentation", "Simulation", "__version__", "draw", "register", "segment", "show",
           "simulate"]

WIDTH = 320  # at which images are worked on [px]
Array = npt.NDArray[np.float64]
Path = Union[str, os.PathLike]


def __dir__() -> List[str]:
    return __all__


def _at(T: Optional[Array]) -> str:
    """The position of a pose, for people."""
    return "nowhere" if T is None else "({:.2f}, {:.2f}, {:.2f}) m".format(*T[:3, 3])


@dataclass(frozen=True, repr=False)
class Segment:
    """A planar surface segment in the camera's frame."""
    R: Array  #: (3, 3): principal axes and, as the last column, the normal, which points away from the camera
    t: Array  #: (3,): centroid [m]
    covariance: Array  #: (3, 3) of the tilts about x and y and of the offset [1, 1, m^2]
    num_points: int  #: pixels of the working image
    area: float  #: of the hull [m^2]
    hull: Array  #: (n, 3): corners of the convex hull [m]

    @property
    def normal(self) -> Array:
        """Unit normal, away from the camera."""
        return self.R[:, 2]

    @property
    def offset(self) -> float:
        """Distance of the plane from the camera [m]."""
        return float(self.normal @ self.t)

    def __repr__(self) -> str:
        normal = ", ".join(f"{n:.2f}" for n in self.normal)
        return f"Segment({self.area:.2f} m^2, {self.num_points} px, normal ({normal}), offset {self.offset:.2f} m)"


@dataclass(frozen=True, repr=False)
class Segmentation:
    """The planes of a depth image."""
    labels: npt.NDArray[np.uint16]  #: of the working image; 0 = none, k = segments[k - 1]
    segments: List[Segment]  #: the most useful first

    def __repr__(self) -> str:
        return f"Segmentation({len(self.segments)} segments of {self.labels.shape[1]}x{self.labels.shape[0]} pixels)"


@dataclass(frozen=True, repr=False)
class Hypothesis:
    """A pose that the camera may have."""
    model: str  #: local model, by its name
    part: str  #: of the map, whose frame is the world; empty: the map's world
    probability: float  #: that this place is the right one
    score: float
    T_m_c: Array  #: in the frame of the local model
    covariance_m: Array  #: of T_m_c
    T_w_c: Optional[Array]  #: in the world, if the local model has a pose there
    covariance: Optional[Array]  #: of T_w_c
    pairs: int  #: segments that took part in it
    depth_assisted: bool  #: one translation comes from pixels, not from planes

    def __repr__(self) -> str:
        return f"Hypothesis({self.model!r}, probability {self.probability:.3g}, at {_at(self.T_w_c)})"


@dataclass(frozen=True)
class NextLook:
    """The motion of the robot after which an answer that is not sure most likely becomes so."""
    yaw_deg: float  #: turn on the spot, to the left if positive
    ahead: float  #: distance to drive after the turn [m]
    sure: float  #: probability that the answer is sure then
    gain: float  #: expected loss of entropy [nats]


@dataclass(frozen=True, repr=False)
class Answer:
    """Where a camera is. Act on it only if it is sure."""
    state: str  #: "sure", "doubtful" or "unknown"
    hypotheses: List[Hypothesis]  #: the most probable first
    not_in_map: float  #: probability that the map does not hold the place
    shares: Dict[str, float]  #: of the view: explained, hiding and new; of the map: missing; empty if unknown
    reason: str  #: why it is not sure; empty if it is
    tracking: str  #: of a moving camera: "searching", "localized", "tracking", "cannot tell", "lost"
    T_w_c: Optional[Array]  #: the most probable pose in the world
    covariance: Optional[Array]  #: of it
    next_look: Optional[NextLook]  #: of an answer that has searched the map and is not sure
    findings: List[dict]  #: about the image's camera and the map, like Recording.findings(); empty if there are none
    maps: Dict[str, float] = field(default_factory=dict)  #: probability of each of several maps (Map.joined())

    @property
    def sure(self) -> bool:
        """Is its state "sure"?"""
        return self.state == "sure"

    @property
    def probability(self) -> float:
        """Of the most probable pose."""
        return self.hypotheses[0].probability if self.hypotheses else 0.0

    def __repr__(self) -> str:
        return f"Answer({self.state}, probability {self.probability:.3g}, at {_at(self.T_w_c)}{', ' + self.reason if self.reason else ''})"


@dataclass(frozen=True, repr=False)
class Registration:
    """The pose of one camera relative to another. Act on it only if it is sure."""
    state: str  #: "sure", "doubtful" or "unknown"
    hypotheses: List[Hypothesis]  #: the most probable first; T_w_c is T_target_source
    reason: str  #: cause of a missing answer; else empty

    @property
    def sure(self) -> bool:
        """Is its state "sure"?"""
        return self.state == "sure"

    @property
    def T_target_source(self) -> Optional[Array]:
        """The most probable pose of the source's camera in the target's."""
        return self.hypotheses[0].T_m_c if self.hypotheses else None

    def __repr__(self) -> str:
        return f"Registration({self.state}, at {_at(self.T_target_source)}{', ' + self.reason if self.reason else ''})"


@dataclass(frozen=True, repr=False)
class LocalModel:
    """The planes that one image of a map shows, as the map lists them."""
    name: str
    stamp: float  #: [s]
    T_w_m: Optional[Array]  #: in the frame of its part of the map, if it is known
    part: str
    segments: int  #: how many

    def __repr__(self) -> str:
        return f"LocalModel({self.name!r}, {self.segments} segments, at {_at(self.T_w_m)})"


@dataclass(frozen=True, repr=False)
class Frame:
    """A depth image of a recording or of a simulated drive."""
    name: str
    stamp: float  #: [s]
    depth: npt.NDArray[np.float32]  #: [m]; 0 = not measured
    T_w_c: Optional[Array] = None  #: its true pose, if it is known
    labels: Optional[npt.NDArray[np.uint16]] = None  #: true planes of a simulated image

    def __repr__(self) -> str:
        return f"Frame({self.name!r}, {self.stamp:.6f} s, {self.depth.shape[1]}x{self.depth.shape[0]} pixels)"


def _answer(values: dict) -> Answer:
    hypotheses = [Hypothesis(**h) for h in values.pop("hypotheses")]
    first = hypotheses[0] if hypotheses else None
    if values["T_w_c"] is None and first is not None:  # of a single image
        values.update(T_w_c=first.T_w_c, covariance=first.covariance)
    look = values.pop("next_look")
    return Answer(hypotheses=hypotheses, next_look=NextLook(**look) if look else None, **values)


def segment(depth: npt.ArrayLike, camera: Camera, width: int = WIDTH) -> Segmentation:
    """The planes of a depth image."""
    labels, segments = _facetloc.segment(image(depth, "depth"), checked(camera, "camera", Camera), whole(width, "width"))
    return Segmentation(labels, [Segment(**s) for s in segments])


def register(source: npt.ArrayLike, target: npt.ArrayLike, camera: Camera, target_camera: Optional[Camera] = None,
             width: int = WIDTH) -> Registration:
    """The pose of the source's camera in the target's, by their planes; no guess is needed. camera is of both images unless
    target_camera is given."""
    target_camera = checked(camera, "camera", Camera) if target_camera is None else checked(target_camera, "target_camera", Camera)
    values = _facetloc.register(image(source, "source"), image(target, "target"), camera, target_camera, whole(width, "width"))
    return Registration(values["state"], [Hypothesis(**h) for h in values["hypotheses"]], values["reason"])


class Recording(Sequence[Frame]):
    """Depth images in files, of any layout that the tools read: Recording.open(path)."""

    def __init__(self, recording: _facetloc.Recording):
        self._recording = recording

    def __repr__(self) -> str:
        return f"Recording({len(self)} images, {self.layout})"

    @classmethod
    def open(cls, path: Path, camera: Path = "", topic: str = "") -> Recording:
        """camera: a camera.ini, a map made with the camera, or a preset's name; counts more than what the recording says. topic: of
        the depth images of a bag."""
        return cls(_facetloc.Recording(as_path(path, "path"), as_path(camera, "camera"), checked(topic, "topic", str)))

    @property
    def camera(self) -> Optional[Camera]:
        """Of the images as they are read, without the distortion of a lens."""
        return self._recording.camera

    @property
    def layout(self) -> str:
        """Its layout, in words."""
        return self._recording.layout

    @property
    def remarks(self) -> List[str]:
        """What to know of it."""
        return self._recording.remarks

    def findings(self) -> List[dict]:
        """As facetloc_check lists them: id, severity ("note", "doubt", "refusal"), words, cure, and evidence, a dict of (value, std).
        Reads some dozen images, and all that have poses."""
        return self._recording.findings()

    def __len__(self) -> int:
        return len(self._recording)

    def __getitem__(self, index):  # reads the image
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        index = range(len(self))[index]
        recording = self._recording
        return Frame(recording.name(index), recording.stamp(index), recording.depth(index, 0), recording.truth(index))


class Map:
    """A map of local models: Map.open(path), or what MapMaking.finish() gives. Maps do not change; pickles have their path."""

    def __init__(self, map_: _facetloc.Map, path: Optional[pathlib.Path] = None):
        self._map = map_
        self.path = path  #: of its file, absolute; None until it is saved

    def __repr__(self) -> str:
        parts = f", {len(self.parts)} parts" if len(self.parts) > 1 else ""
        return f"Map({len(self)} local models, {len(self.links)} links{parts}{'' if self.path is None else f', {str(self.path)!r}'})"

    def __copy__(self) -> Map:
        return self

    def __deepcopy__(self, memo: dict) -> Map:
        return self

    def __reduce__(self):
        if self.path is None:
            raise TypeError("a map is pickled by its path: save() it first")
        return Map.open, (str(self.path),)

    @classmethod
    def open(cls, path: Path) -> Map:
        """Reads a map file. Raises IoError, with the cause."""
        path = as_path(path, "path")
        return cls(_facetloc.Map.open(path), pathlib.Path(path).resolve())

    @classmethod
    def joined(cls, maps: Dict[str, Map]) -> Map:
        """Several maps by their names, such as floors, as one: Localizer answers in which (Answer.maps, and the part of a place)."""
        return cls(_facetloc.Map.joined({name: one._map for name, one in maps.items()}))

    def save(self, path: Path) -> None:
        """Writes it as a whole beside path and renames it then."""
        path = as_path(path, "path")
        self._map.save(path)
        self.path = pathlib.Path(path).resolve()

    def __len__(self) -> int:
        return len(self._map)

    @property
    def models(self) -> List[LocalModel]:
        """Its local models, one for each image that it was made of."""
        return [LocalModel(**self._map.model(i)) for i in range(len(self))]

    def segments(self, index: int) -> List[Segment]:
        """The planes of a local model, in its frame."""
        return [Segment(**s) for s in self._map.segments(range(len(self))[index])]

    @property
    def links(self) -> List[Tuple[int, int, Array]]:
        """(from, to, T_from_to), by index of the local models."""
        return self._map.links

    @property
    def parts(self) -> List[str]:
        """Names of the parts, whose relative poses are unknown; empty for a map of one."""
        return self._map.parts


class MapMaking:
    """Makes a map of one run of depth images, with poses or without. Keeps them in memory, 0.3 MB each."""

    def __init__(self, camera: Camera, width: int = WIDTH, threads: int = 1):
        self._making = _facetloc.MapMaking(checked(camera, "camera", Camera), whole(width, "width"), whole(threads, "threads"))
        self._images = 0

    def __repr__(self) -> str:
        return f"MapMaking({self._images} images)"

    def add(self, depth: npt.ArrayLike, stamp: float, name: str = "", T_w_c: Optional[npt.ArrayLike] = None,
            gravity: Optional[npt.ArrayLike] = None) -> None:
        """The next image. Names default to stamps. gravity: downwards, in the camera's axes."""
        stamp = real(stamp, "stamp")
        self._making.add(image(depth, "depth"), stamp, checked(name, "name", str) or f"{stamp:.6f}", numbers(T_w_c, "T_w_c"),
                         numbers(gravity, "gravity"))
        self._images += 1

    def finish(self) -> Map:
        """Raises RuntimeError, with the reason, if no map can be made."""
        return Map(self._making.finish())

    @property
    def findings(self) -> dict:
        """What was found beside the map: unread and without_segments (numbers of images), mounting and poses (in words), and a list of
        findings like Recording.findings()."""
        return self._making.findings()


Depth = Union[npt.ArrayLike, Sequence[npt.ArrayLike]]
Cameras = Union[Camera, Sequence[Camera]]


def _images(depth: Depth, camera: Cameras) -> Tuple[List[np.ndarray], List[Camera]]:
    """One image and its camera, or several of one moment, as lists."""
    if not isinstance(camera, (list, tuple)):
        return [image(depth, "depth")], [checked(camera, "camera", Camera)]
    if not isinstance(depth, (list, tuple)) or len(depth) != len(camera) or not camera:
        raise ValueError(f"depth is no list of {len(camera)} images, as camera is of cameras")
    return [image(one, "depth") for one in depth], [checked(one, "camera", Camera) for one in camera]


class Localizer:
    """Where a camera is in a map: localize() for a single image, update() for the next one of a moving camera.

    Several cameras on a robot are one: Localizer(map, rig=[front, rear]).localize([front_depth, rear_depth], [front, rear]). Each
    has its mounting (mount_height, ...), and the answer is about the first one. An image that is missing is left out of both lists."""

    def __init__(self, map: Map, width: int = WIDTH, threads: int = 1, min_probability: Optional[float] = None,
                 rig: Sequence[Camera] = ()):
        """min_probability: of a sure answer; unless given, as the map was calibrated, else 0.9. threads: 0 = all cores; the answer is
        the same."""
        least = None if min_probability is None else real(min_probability, "min_probability", 0, 1)
        self._localizer = _facetloc.Localizer(checked(map, "map", Map)._map, whole(width, "width"), whole(threads, "threads"), least,
                                              [checked(camera, "rig", Camera) for camera in rig])
        self._map = map

    def __repr__(self) -> str:
        return f"Localizer({self._map!r})"

    def localize(self, depth: Depth, camera: Cameras, gravity: Optional[npt.ArrayLike] = None,
                 near: Optional[npt.ArrayLike] = None, std_m: float = 1, std_deg: float = 30) -> Answer:
        """By this image alone; near: a pose T_w_c somebody believes in, with its standard deviations."""
        return _answer(self._localizer.localize(*_images(depth, camera), numbers(gravity, "gravity"),
                                                numbers(near, "near"), real(std_m, "std_m", 0), real(std_deg, "std_deg", 0)))

    def update(self, depth: Depth, camera: Cameras, stamp: float, motion: Optional[npt.ArrayLike] = None,
               motion_covariance: Optional[npt.ArrayLike] = None, gravity: Optional[npt.ArrayLike] = None) -> Answer:
        """By all images so far. motion: T_before_now of the camera by an odometry, with its covariance."""
        return _answer(self._localizer.update(*_images(depth, camera), real(stamp, "stamp"), numbers(motion, "motion"),
                                              numbers(motion_covariance, "motion_covariance"), numbers(gravity, "gravity")))

    def set_pose(self, T_w_c: npt.ArrayLike, covariance: Optional[npt.ArrayLike] = None, std_m: float = 1, std_deg: float = 30,
                 part: str = "") -> None:
        """The camera is about there at the next image; all images before are forgotten."""
        if T_w_c is None:
            refuse(T_w_c, "T_w_c", "an array of numbers")
        self._localizer.set_pose(numbers(T_w_c, "T_w_c"), numbers(covariance, "covariance"), real(std_m, "std_m", 0),
                                 real(std_deg, "std_deg", 0), checked(part, "part", str))

    def reset(self) -> None:
        """Forgets all images."""
        self._localizer.reset()


class Simulation(Sequence[Frame]):
    """Images of a simulated drive, rendered when they are asked for."""

    def __init__(self, drive: _facetloc.Drive):
        self._drive = drive

    def __repr__(self) -> str:
        return f"Simulation({len(self)} images)"

    @property
    def camera(self) -> Camera:
        """The camera of its images, as it is mounted."""
        return self._drive.camera

    def __len__(self) -> int:
        return len(self._drive)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        index = range(len(self))[index]
        return Frame(name=f"{index:06d}", stamp=float(index), **self._drive.frame(index))


def simulate(scene: str = "room", run: str = "map", seed: int = 1, frames: int = 30, width: int = WIDTH) -> Simulation:
    """A robot with a depth camera drives through a made-up place: room, office, home, hall, corridor, hotel, boards, doors, passage or box.
    run: "map", or "query", later, when things have moved. The same arguments give the same images."""
    return Simulation(_facetloc.Drive(checked(scene, "scene", str), checked(run, "run", str), whole(seed, "seed"),
                                      whole(frames, "frames", 1), whole(width, "width", 32)))
