# SPDX-License-Identifier: BSD-3-Clause
"""import facetloc: as the tools answer, and as the simulator knows better."""
import copy
import csv
import html
import inspect
import json
import os
import pathlib
import pickle
import pydoc
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import facetloc

TOOLS = pathlib.Path(os.environ["FACETLOC_TOOLS"])
EXAMPLES = pathlib.Path(os.environ["FACETLOC_EXAMPLES"])


def run(*command):
    return subprocess.run([str(c) for c in command], check=True, capture_output=True, text=True)


@pytest.fixture(scope="session")
def room(tmp_path_factory):
    """A simulated room as the tools make it, its map, and what facetloc_localize answers."""
    folder = tmp_path_factory.mktemp("room")
    run(TOOLS / "facetloc_simulate", "room", "-o", folder, "--seed", 5, "--frames", 24, "--width", 320)
    run(TOOLS / "facetloc_map", "build", folder / "map", "-o", folder / "room.flmap")
    run(TOOLS / "facetloc_localize", folder / "room.flmap", folder / "query", "-o", folder / "results")
    run(TOOLS / "facetloc_localize", folder / "room.flmap", folder / "query", "-o", folder / "drive", "--sequence")
    return folder


def first_rows(folder):
    with open(folder / "hypotheses.csv", encoding="utf-8", newline="") as file:
        return {row["frame"]: row for row in csv.DictReader(file) if int(row["rank"] or 0) <= 1}


def agree(answer, row):
    assert answer.state == row["state"]
    if answer.state == "unknown":
        assert answer.reason == row["reason"]
        return
    first = answer.hypotheses[0]
    assert first.model == row["model"]
    assert f"{first.probability:.9g}" == row["probability"]
    assert f"{first.score:.9g}" == row["score"]
    for axis, name in enumerate(("w_tx", "w_ty", "w_tz")):
        assert f"{first.T_w_c[axis, 3]:.9g}" == row[name]
        assert abs(first.T_m_c[axis, 3] - float(row["m_" + name[2:]])) < 1e-8


def test_localizes_as_the_tool_does(room):
    recording = facetloc.Recording.open(room / "query")
    localizer = facetloc.Localizer(facetloc.Map.open(room / "room.flmap"))
    rows = first_rows(room / "results")
    assert len(recording) == len(rows) == 24
    for frame in recording:
        agree(localizer.localize(frame.depth, recording.camera), rows[frame.name])
    assert sum(row["state"] == "sure" for row in rows.values()) > 5


def test_an_answer_has_findings_about_its_camera(room):
    recording, of_map = facetloc.Recording.open(room / "query"), facetloc.Map.open(room / "room.flmap")
    depth, c = recording[0].depth, recording.camera
    localizer = facetloc.Localizer(of_map)
    assert localizer.localize(depth, c).findings == []
    other = facetloc.Camera(width=c.width, height=c.height, fx=1.3 * c.fx, fy=1.3 * c.fy, cx=c.cx, cy=c.cy)
    assert "camera.difference" in [f["id"] for f in localizer.localize(depth, other).findings]


def test_follows_a_drive_as_the_tool_does(room):
    recording = facetloc.Recording.open(room / "query")
    localizer = facetloc.Localizer(facetloc.Map.open(room / "room.flmap"))
    rows = first_rows(room / "drive")
    for frame in recording:
        agree(localizer.update(frame.depth, recording.camera, frame.stamp), rows[frame.name])


def test_answers_are_right(room):
    recording = facetloc.Recording.open(room / "query")
    localizer = facetloc.Localizer(facetloc.Map.open(room / "room.flmap"))
    for frame in recording:
        answer = localizer.localize(frame.depth, recording.camera)
        if answer.sure:
            assert np.linalg.norm(answer.T_w_c[:3, 3] - frame.T_w_c[:3, 3]) < 0.2
            np.linalg.cholesky(answer.covariance)  # positive definite
            assert answer.covariance.shape == (6, 6)


def test_several_cameras_are_one_view(room):
    recording, of_map = facetloc.Recording.open(room / "query"), facetloc.Map.open(room / "room.flmap")
    both = [recording.camera] * 2  # the second stands where the first one does
    localizer = facetloc.Localizer(of_map, rig=both)
    answers = [(localizer.localize([frame.depth] * 2, both), frame) for frame in recording]
    sure = [(answer, frame) for answer, frame in answers if answer.sure]
    assert len(sure) > 5
    for answer, frame in sure:
        assert np.linalg.norm(answer.T_w_c[:3, 3] - frame.T_w_c[:3, 3]) < 0.2
    depth, c = recording[0].depth, recording.camera
    bare = facetloc.Camera(width=c.width, height=c.height, fx=c.fx, fy=c.fy, cx=c.cx, cy=c.cy)
    with pytest.raises(ValueError, match="no mounting"):
        localizer.localize([depth, depth], [c, bare])
    with pytest.raises(ValueError, match="^depth is no list of 2 images"):
        localizer.localize(depth, both)


def test_whole_numbers_and_metres_are_the_same_image(room):
    recording = facetloc.Recording.open(room / "query")
    depth = recording[0].depth
    camera = recording.camera
    whole = np.round(depth * camera.depth_scale).astype(np.uint16)
    a, b = facetloc.segment(depth, camera), facetloc.segment(whole, camera)
    assert np.array_equal(a.labels, b.labels)
    assert len(a.segments) == len(b.segments) > 2


def test_masked_pixels_are_not_measured(room):
    recording = facetloc.Recording.open(room / "query")
    depth, mask = np.array(recording[0].depth), np.zeros(recording[0].depth.shape, bool)
    mask[:, :100] = True
    masked = facetloc.segment(np.ma.array(depth, mask=mask), recording.camera)
    depth[mask] = 0
    assert np.array_equal(masked.labels, facetloc.segment(depth, recording.camera).labels)


def test_a_recording_has_the_findings_of_the_tool(room, tmp_path):
    run(TOOLS / "facetloc_check", room / "query", "--findings", tmp_path / "findings.json")
    of_tool = json.loads((tmp_path / "findings.json").read_text(encoding="utf-8"))
    found = facetloc.Recording.open(room / "query").findings()
    assert {f["id"] for f in found} <= {f["id"] for f in of_tool}
    assert "poses.accuracy" in {f["id"] for f in found}
    assert not [f for f in found if f["severity"] != "note"]


def test_segments_are_planes_of_the_scene():
    drive, of_one, of_all = facetloc.simulate("room", seed=3, frames=6), 0, 0
    for frame in drive:
        found = facetloc.segment(frame.depth, drive.camera, width=0)
        assert found.labels.shape == frame.depth.shape
        assert found.labels.max() == len(found.segments)
        for k, segment in enumerate(found.segments, start=1):
            inside = found.labels == k
            v, u = np.nonzero(inside)
            z = frame.depth[inside]
            c = drive.camera
            points = np.stack([(u - c.cx) / c.fx * z, (v - c.cy) / c.fy * z, z], axis=1)
            distance = points @ segment.normal - segment.offset
            assert np.median(np.abs(distance)) < 0.03
            truth = frame.labels[inside]
            of_one, of_all = of_one + np.bincount(truth).max(), of_all + truth.size
    assert of_all > 0.5 * 6 * 320 * 240
    assert of_one > 0.95 * of_all, "pixels of a segment are of one plane of the scene"


def test_registers_two_images():
    drive = facetloc.simulate("room", seed=5, frames=6)
    a, b = drive[0], drive[1]
    answer = facetloc.register(b.depth, a.depth, drive.camera)
    truth = np.linalg.inv(a.T_w_c) @ b.T_w_c
    assert answer.state != "unknown", answer.reason
    assert np.linalg.norm(answer.T_target_source[:3, 3] - truth[:3, 3]) < 0.1


def test_makes_maps_and_saves_them(tmp_path):
    drive = facetloc.simulate("room", seed=5, frames=24)
    making = facetloc.MapMaking(drive.camera)
    for frame in drive:
        making.add(frame.depth, frame.stamp, T_w_c=frame.T_w_c)
    made = making.finish()
    assert len(made) > 3
    assert any(model.T_w_m is not None for model in made.models)
    made.save(tmp_path / "own.flmap")
    assert "sound" in run(TOOLS / "facetloc_map", "check", tmp_path / "own.flmap").stdout
    again = facetloc.Map.open(tmp_path / "own.flmap")
    assert [m.name for m in again.models] == [m.name for m in made.models]
    frame = drive[5]
    answer = facetloc.Localizer(again).localize(frame.depth, drive.camera)
    assert answer.sure
    assert np.linalg.norm(answer.T_w_c[:3, 3] - frame.T_w_c[:3, 3]) < 0.1


def test_several_threads_add_to_one_map():
    frame = facetloc.simulate("room", seed=5, frames=2)[0]
    making = facetloc.MapMaking(facetloc.simulate("room", seed=5, frames=2).camera)

    def add(first):
        for stamp in range(first, 800, 8):
            making.add(frame.depth, stamp, T_w_c=frame.T_w_c)
    threads = [threading.Thread(target=add, args=(first,)) for first in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(making.finish()) == 1, "all images are the same"


def test_a_start_decides_and_is_forgotten(room):
    recording = facetloc.Recording.open(room / "query")
    localizer = facetloc.Localizer(facetloc.Map.open(room / "room.flmap"))
    frame = next(f for f in recording if f.T_w_c is not None)
    localizer.set_pose(frame.T_w_c, std_m=0.1, std_deg=5)
    answer = localizer.update(frame.depth, recording.camera, frame.stamp)
    assert np.linalg.norm(answer.T_w_c[:3, 3] - frame.T_w_c[:3, 3]) < 0.3
    localizer.reset()
    assert localizer.localize(frame.depth, recording.camera, near=frame.T_w_c).hypotheses


def test_errors_are_exceptions_with_the_sentences_of_the_tools(room, tmp_path):
    with pytest.raises(OSError, match="does not exist"):
        facetloc.Map.open(tmp_path / "none.flmap")
    with pytest.raises(facetloc.IoError, match="fx = -1 is impossible"):
        facetloc.Camera(width=4, height=3, fx=-1, fy=1, cx=1, cy=1)
    with pytest.raises(facetloc.IoError, match="nothing is known of the camera"):
        facetloc.Camera(width=4, height=3)
    with pytest.raises(TypeError, match="a camera has no 'focal'"):
        facetloc.Camera(focal=3)
    camera = facetloc.Camera(width=4, height=3, fx=3, fy=3, cx=1, cy=1)
    with pytest.raises(ValueError, match=r"the shape \(4, 3\), not \(3, 4\)"):
        facetloc.segment(np.zeros((4, 3)), camera)
    for kind in (np.int64, np.uint8):
        with pytest.raises(ValueError, match=f"of the type {np.dtype(kind)}, not uint16"):
            facetloc.segment(np.zeros((3, 4), dtype=kind), camera)
    with pytest.raises(ValueError, match="they are millimetres"):
        facetloc.segment(np.full((3, 4), 1500.0), camera)
    assert not facetloc.segment(np.zeros((3, 4), dtype=np.uint16), camera).segments
    localizer = facetloc.Localizer(facetloc.Map.open(room / "room.flmap"))
    with pytest.raises(ValueError, match="no rigid transform"):
        localizer.set_pose(2 * np.eye(4))
    with pytest.raises(ValueError, match="no part 'cellar'"):
        localizer.set_pose(np.eye(4), part="cellar")
    with pytest.raises(ValueError, match="motion_covariance is missing"):
        localizer.update(np.zeros((3, 4)), camera, 0, motion=np.eye(4))
    with pytest.raises(RuntimeError):
        facetloc.MapMaking(camera).finish()
    with pytest.raises(ValueError, match="moon"):
        facetloc.simulate("moon")


def test_errors_name_the_argument(room):
    office = facetloc.Map.open(room / "room.flmap")
    camera, depth = facetloc.Camera("kinect", width=320, height=240), np.zeros((240, 320), np.uint16)
    localizer, making = facetloc.Localizer(office), facetloc.MapMaking(camera)
    for error, words, call in (
            (TypeError, "^depth is of the type Camera", lambda: facetloc.segment(camera, depth)),
            (TypeError, "^camera is of the type ndarray, not Camera", lambda: facetloc.segment(depth, depth)),
            (TypeError, "^target_camera is of the type Map", lambda: facetloc.register(depth, depth, camera, office)),
            (ValueError, r"^target has the shape \(3, 4\)", lambda: facetloc.register(depth, np.zeros((3, 4)), camera)),
            (ValueError, "^width = -1", lambda: facetloc.segment(depth, camera, width=-1)),
            (TypeError, "^map is of the type str, not Map", lambda: facetloc.Localizer("room.flmap")),
            (ValueError, r"^min_probability = 2 .* \[0, 1\]", lambda: facetloc.Localizer(office, min_probability=2)),
            (TypeError, "^threads is of the type float", lambda: facetloc.Localizer(office, threads=1.5)),
            (TypeError, "^path is of the type NoneType", lambda: facetloc.Map.open(None)),
            (TypeError, "^camera is of the type Camera, not a path", lambda: facetloc.Recording.open(room / "query", camera=camera)),
            (ValueError, "^near is no rigid transform", lambda: localizer.localize(depth, camera, near=2 * np.eye(4))),
            (TypeError, "^near is of the type str", lambda: localizer.localize(depth, camera, near="here")),
            (ValueError, "^covariance has the shape", lambda: localizer.set_pose(np.eye(4), covariance=np.eye(3))),
            (ValueError, "^stamp = nan", lambda: localizer.update(depth, camera, float("nan"))),
            (TypeError, "^stamp is of the type str", lambda: making.add(depth, "now")),
            (ValueError, "^gravity has not three", lambda: making.add(depth, 0, gravity=[1])),
            (ValueError, "^frames = 0", lambda: facetloc.simulate(frames=0)),
            (TypeError, r"^answers\[0\] is of the type int", lambda: facetloc.draw(office, [1])),
            (TypeError, "give one of them", lambda: facetloc.Camera("kinect", camera="kinect")),
            (OSError, "known: kinect, xtion", lambda: facetloc.Camera("webcam"))):
        with pytest.raises(error, match=words):
            call()


def test_everything_is_described_at_run_time(room):
    assert all(hasattr(facetloc, name) for name in facetloc.__all__)
    cmake = (EXAMPLES / "../../CMakeLists.txt").read_text(encoding="utf-8")
    assert f"project(facetloc VERSION {facetloc.__version__} " in cmake
    for name in facetloc.__all__:
        described = getattr(facetloc, name)
        if not isinstance(described, type):
            continue
        assert inspect.getdoc(described), name
        for member, value in vars(described).items():
            if not member.startswith("_") and (callable(value) or isinstance(value, (property, staticmethod, classmethod))):
                assert inspect.getdoc(value), f"{name}.{member}"
    assert "Camera(\"azure_kinect\")" in pydoc.render_doc(facetloc.Camera)
    drive, office = facetloc.Recording.open(room / "query"), facetloc.Map.open(room / "room.flmap")
    localizer = facetloc.Localizer(office)
    answer = localizer.localize(drive[0].depth, drive.camera)
    texts = [repr(x) for x in (drive, drive[0], drive.camera, office, office.models[0], office.segments(0)[0], localizer, answer,
                               facetloc.MapMaking(drive.camera), facetloc.segment(drive[0].depth, drive.camera), *answer.hypotheses)]
    assert all(len(text) < 400 and " object at " not in text for text in texts)
    assert eval(repr(drive.camera), {"Camera": facetloc.Camera}) == drive.camera  # pylint: disable=eval-used


def test_a_preset_is_a_camera_with_its_usual_images():
    for name in facetloc.Camera.presets():
        camera = facetloc.Camera(name)
        assert camera == facetloc.Camera(camera=name, width=camera.width, height=camera.height)
        assert 0.4 < camera.fx / camera.width < 2 and abs(camera.cx / camera.width - 0.5) < 0.1
    assert facetloc.Camera("kinect", width=320, height=240).fx == facetloc.Camera("kinect").fx / 2


def test_cameras_and_maps_can_be_copied_and_pickled(room, tmp_path):
    camera = facetloc.Camera("azure_kinect", mount_height=0.98, mount_tilt_deg=10, k1=1 / 3, depth_is="distance")
    for other in (pickle.loads(pickle.dumps(camera)), copy.copy(camera), copy.deepcopy([camera])[0], facetloc.Camera(**camera.keys)):
        assert other == camera and hash(other) == hash(camera) and np.array_equal(other.T_b_c, camera.T_b_c)
    assert camera != facetloc.Camera("azure_kinect") and camera != 3
    office = facetloc.Map.open(room / "room.flmap")
    again = pickle.loads(pickle.dumps(office))
    assert again.path == office.path and [m.name for m in again.models] == [m.name for m in office.models]
    assert len(copy.copy(office)) == len(copy.deepcopy([office])[0]) == len(office)
    own = _map_of("room", 5)
    with pytest.raises(TypeError, match="save"):
        pickle.dumps(own)
    own.save(tmp_path / "own.flmap")
    assert len(pickle.loads(pickle.dumps(own))) == len(own)


def _map_of(scene, seed):
    drive = facetloc.simulate(scene, seed=seed, frames=12)
    making = facetloc.MapMaking(drive.camera)
    for frame in drive:
        making.add(frame.depth, frame.stamp, T_w_c=frame.T_w_c)
    return making.finish()


def test_a_map_is_drawn_with_its_walls_and_answers(room):
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("Agg")
    office, drive = facetloc.Map.open(room / "room.flmap"), facetloc.Recording.open(room / "query")
    localizer = facetloc.Localizer(office)
    answers = [localizer.update(frame.depth, drive.camera, frame.stamp) for frame in drive]
    ax = facetloc.draw(office, answers)
    walls, *arrows = ax.collections
    ends = np.concatenate(walls.get_segments())
    truth = np.array([f.T_w_c[:2, 3] for f in drive])
    assert np.all(ends.min(axis=0) < truth.min(axis=0)) and np.all(ends.max(axis=0) > truth.max(axis=0)), "walls enclose the drive"
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    sure = sum(answer.sure for answer in answers)
    assert f"sure ({sure})" in labels and len(ax.patches) == sure > 5
    assert facetloc.draw(office, answers[-1], ax=ax) is ax


def test_a_map_is_shown_as_a_page(room, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(FileNotFoundError, match="facetloc_render"):
        facetloc.show(facetloc.Map.open(room / "room.flmap"))
    monkeypatch.setenv("PATH", f"{TOOLS}:/usr/bin:/bin")
    page = facetloc.show(facetloc.Map.open(room / "room.flmap"), tmp_path / "page.html")
    assert opened == [(tmp_path / "page.html").as_uri()] and page.path.stat().st_size > 50000
    monkeypatch.setitem(sys.modules, "ipykernel", object())
    page = facetloc.show(_map_of("room", 5))  # never saved
    assert len(opened) == 1, "a notebook shows it in its own page"
    frame = page._repr_html_()
    assert frame.startswith("<iframe srcdoc=") and html.unescape(frame.split('"')[1]) == page.path.read_text(encoding="utf-8")


def test_others_run_while_it_computes(room):
    """Counts in another thread, which the lock of the interpreter would stop for as long as a map takes."""
    recording = facetloc.Recording.open(room / "map")
    making = facetloc.MapMaking(recording.camera)
    for frame in recording:
        making.add(frame.depth, frame.stamp)  # without poses, which takes longer
    begun, longest, stop = time.monotonic(), [0.0], threading.Event()

    def tick():
        last = time.monotonic()
        while not stop.is_set():
            time.sleep(0.001)
            now = time.monotonic()
            longest[0], last = max(longest[0], now - last), now
    thread = threading.Thread(target=tick)
    thread.start()
    making.finish()
    stop.set()
    thread.join()
    assert longest[0] < 0.5 * (time.monotonic() - begun)


def test_readme(room, tmp_path, monkeypatch, capsys):
    text = (EXAMPLES / "../../README.md").read_text(encoding="utf-8")
    code = text.split("```python\n")[1].split("```")[0]
    (tmp_path / "walk").symlink_to(room)
    (tmp_path / "walk.flmap").symlink_to(room / "room.flmap")
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})  # pylint: disable=exec-used
    assert capsys.readouterr().out.strip()


def test_first_steps(tmp_path):
    pytest.importorskip("matplotlib")
    picture = tmp_path / "steps.png"
    out = run(sys.executable, EXAMPLES / "first_steps.py", picture).stdout
    assert "local models" in out and out.count(": sure (p ") >= 12
    assert picture.stat().st_size > 10000
