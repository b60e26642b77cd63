"""OpenCV's matrices, dicts, .npz files, COLMAP models; import of photographs."""

from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path

import ffprocams as ffp
import numpy as np
import pytest
from ffprocams.devices import inverse, rigid, rotation_of

K = np.array([[500.0, 0, 319.5], [0, 510.0, 239.5], [0, 0, 1]])
RVEC, TVEC = np.array([0.1, -0.4, 0.2]), np.array([0.3, -0.1, 0.05])


def project(device: ffp.Pinhole, point: np.ndarray) -> np.ndarray:
    x = inverse(device.pose) @ np.append(point, 1)
    return np.array([device.cx + device.fx * x[0] / x[2], device.cy + device.fy * x[1] / x[2]])


def test_rvec_and_tvec() -> None:
    r = rotation_of(RVEC)
    np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(r @ RVEC, RVEC, atol=1e-12)  # its own axis
    assert np.trace(r) == pytest.approx(1 + 2 * np.cos(np.linalg.norm(RVEC)))
    np.testing.assert_allclose(rotation_of((0, 0, np.pi / 2)) @ (1, 0, 0), (0, 1, 0), atol=1e-12)
    np.testing.assert_array_equal(rotation_of(np.zeros((3, 1))), np.eye(3))
    for wrong in (np.diag((1, 1, -1)), 2 * np.eye(3)):
        with pytest.raises(ffp.ArgumentError, match="scales or mirrors"):
            rotation_of(wrong)
    camera = ffp.Pinhole.from_opencv(K, RVEC, TVEC, (640, 480))
    point = np.array([0.2, 0.1, 3.0])
    x = r @ point + TVEC  # as OpenCV projects, whose pixel centres are integers
    np.testing.assert_allclose(project(camera, point), [500 * x[0] / x[2] + 320, 510 * x[1] / x[2] + 240])
    np.testing.assert_allclose(camera.matrix - K, [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
    with pytest.raises(ffp.ArgumentError, match="skew"):
        ffp.Pinhole.from_opencv(K + [[0, 5, 0], [0, 0, 0], [0, 0, 0]], RVEC, TVEC, (640, 480))


def calibration() -> dict[str, object]:
    return {
        "camK": K,
        "prjK": K * [[2, 1, 2], [1, 2, 2], [1, 1, 1]],
        "R": rotation_of(RVEC),
        "T": TVEC[:, None],
        "camera_size": (640, 480),
        "projector_size": (1280, 960),
    }


def test_dicts_and_files(tmp_path: Path) -> None:
    found = ffp.Calibration.from_dict(calibration())
    point = np.array([0.1, -0.2, 2.0])
    x = rotation_of(RVEC) @ point + TVEC
    np.testing.assert_allclose(project(found.projector, point)[0], 1000 * x[0] / x[2] + 639 + 0.5)
    assert not found.distorted
    np.savez(tmp_path / "rig.npz", **{**calibration(), "camKc": [0.1, 0, 0, 0, 0, 0]})
    loaded = ffp.Calibration.load(tmp_path / "rig.npz")
    np.testing.assert_array_equal(loaded.projector.pose, found.projector.pose)
    assert loaded.distorted and loaded.camera_distortion[0] == 0.1
    lists = {k: np.asarray(v).tolist() for k, v in calibration().items()}
    (tmp_path / "rig.json").write_text(json.dumps(lists))
    assert ffp.Calibration.load(tmp_path / "rig.json").camera.cx == 320
    for key, words in (("camK", "camera_matrix"), ("T", "translation"), ("projector_size", "projector_size")):
        with pytest.raises(ffp.ArgumentError, match=words):
            ffp.Calibration.from_dict({k: v for k, v in calibration().items() if k != key})
    with pytest.raises(ffp.ArgumentError, match="same"):
        ffp.Calibration.from_dict({**calibration(), "rvec": RVEC})
    with pytest.raises(ffp.ArgumentError, match="k3"):
        ffp.Calibration.from_dict({**calibration(), "camKc": [0, 0, 0, 0, 0, 0.1]})
    for name, text in (("a.npz", "x"), ("a.json", "{"), ("b.json", "[]")):
        (tmp_path / name).write_text(text)
        with pytest.raises(ffp.FileFormatError) as wrong:
            ffp.Calibration.load(tmp_path / name)
        assert wrong.value.file == str(tmp_path / name)


def test_a_shape_is_height_and_width(tmp_path: Path) -> None:
    """img_shape as the program writes and reads it: the same file through both readers, of pictures that are wide."""
    rig = {"cam_int": K, "cam_dist": [0.0] * 5, "proj_int": K, "proj_dist": [0.0] * 5}
    rig |= {"rotation": rotation_of(RVEC), "translation": TVEC[:, None], "img_shape": [[60], [96]]}
    found = ffp.Calibration.from_dict(rig, projector_size=(128, 80))
    assert (found.camera.width, found.camera.height) == (96, 60)
    sides = {"camW": 96, "camH": 60, "prjW": 128, "prjH": 80}  # as `ffprocams calibrate` writes them too
    both = ffp.Calibration.from_dict({**rig, **sides})
    assert (both.camera.width, both.camera.height) == (96, 60)
    assert (both.projector.width, both.projector.height) == (128, 80)
    with pytest.raises(ffp.ArgumentError, match="differ"):
        ffp.Calibration.from_dict({**rig, **sides, "camW": 97})
    grey = np.full((60, 96, 3), 90, np.uint8)
    for name, picture in (("black", grey // 9), ("white", 2 * grey), ("x", grey)):
        picture[20:40, 30:60] += 40  # masks from light need an object
        write_png(tmp_path / f"{name}.png", picture)
    write_png(tmp_path / "shown.png", np.tile(np.arange(128, dtype=np.uint8)[None, :, None], (80, 1, 3)))
    lists = {key: np.asarray(value).tolist() for key, value in {**rig, "img_shape": [60, 96]}.items()}
    (tmp_path / "rig.json").write_text(json.dumps(lists))
    images = {name: tmp_path / f"{name}.png" for name in ("black", "white", "x")}
    for calibration, out in (
        (tmp_path / "rig.json", "by_program"),
        (ffp.Calibration.load(tmp_path / "rig.json", projector_size=(128, 80)), "by_python"),
    ):
        ffp.import_capture(
            tmp_path / out,
            calibration,
            images=images,
            patterns={"x": tmp_path / "shown.png"},
            projector=ffp.CalibratedAt(128, 80),
            width=96,
        )
    for name, picture in (("black", grey // 9), ("white", 2 * grey)):
        write_png(tmp_path / f"empty_{name}.png", picture)
    ffp.import_capture(
        tmp_path / "by_stage",
        tmp_path / "rig.json",
        images=images,
        patterns={"x": tmp_path / "shown.png"},
        empty={name: tmp_path / f"empty_{name}.png" for name in ("black", "white")},
        projector=ffp.CalibratedAt(128, 80),
        width=96,
    )
    assert ffp.Capture.open(tmp_path / "by_stage").coverage(0)[22:38, 32:58].min() > 0.9
    one, other = (ffp.Capture.open(tmp_path / out).camera(0) for out in ("by_program", "by_python"))
    assert (one.width, one.height) == (other.width, other.height) == (96, 60)
    assert (one.fx, one.cx, one.cy) == pytest.approx((other.fx, other.cx, other.cy))


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    bent = ffp.Calibration.from_dict({**calibration(), "camKc": [0.1, -0.2, 0.01, 0.02, 0.3], "D2": [0.05]})
    bent.save(tmp_path / "rig.json")
    loaded = ffp.Calibration.load(tmp_path / "rig.json", (640, 480), (1280, 960))
    np.testing.assert_array_equal(loaded.camera_distortion, bent.camera_distortion)
    np.testing.assert_array_equal(loaded.projector_distortion, bent.projector_distortion)
    np.testing.assert_allclose(loaded.projector.pose, bent.projector.pose, atol=1e-12)


def test_turntables() -> None:
    rig = ffp.Calibration.from_dict(calibration())
    axis, point = np.array([0.1, -1.0, 0.2]), np.array([0.1, 0.2, 2.0])
    stops = rig.turned(axis, point, (0, 40))
    on_object = np.array([0.1, 0.2, 0.3])  # in the object's frame
    at_0 = (stops[0][0].pose @ np.append(0 * on_object, 1))[:3]
    assert np.isfinite(at_0).all()
    start = (inverse(stops[0][0].pose) @ np.append(on_object, 1))[:3]  # in the camera's frame
    turn = rotation_of(axis / np.linalg.norm(axis) * np.radians(40))
    np.testing.assert_allclose(
        (inverse(stops[1][0].pose) @ np.append(on_object, 1))[:3], turn @ (start - point) + point
    )
    between = inverse(stops[1][0].pose) @ stops[1][1].pose  # the rig itself does not move
    np.testing.assert_allclose(between, rig.projector.pose, atol=1e-12)


def test_colmap(tmp_path: Path) -> None:
    pycolmap = pytest.importorskip("pycolmap", reason="skipped: no pycolmap")
    (tmp_path / "cameras.txt").write_text(
        "1 PINHOLE 640 480 500 510 320 240\n2 OPENCV 640 480 500 510 320 240 0 0 0 0\n"
    )
    (tmp_path / "images.txt").write_text("1 0.9238795 0 0.3826834 0 1 2 3 1 view.png\n\n")
    (tmp_path / "points3D.txt").write_text("")
    found = ffp.pinholes_from_pycolmap(tmp_path)["view.png"]
    assert (found.width, found.height, found.fx, found.fy, found.cx, found.cy) == (
        640,
        480,
        500,
        510,
        320,
        240,
    )
    world_to_camera = rigid((0, np.pi / 4, 0), (1, 2, 3))
    np.testing.assert_allclose(found.pose, inverse(world_to_camera), atol=1e-6)
    (tmp_path / "images.txt").write_text("1 1 0 0 0 1 2 3 2 bent.png\n\n")
    with pytest.raises(ffp.ArgumentError, match="OPENCV"):
        ffp.pinholes_from_pycolmap(pycolmap.Reconstruction(tmp_path))


def write_png(path: Path, picture: np.ndarray) -> None:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width, _ = picture.shape
    rows = b"".join(b"\0" + row.tobytes() for row in picture)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(rows))
        + chunk(b"IEND", b"")
    )


def test_photographs_are_imported(capture: ffp.Capture, sample: Path, tmp_path: Path) -> None:
    """The sample's first view as a rig of one view, from a dict of OpenCV's matrices and files of photographs."""
    camera, projector = capture.camera(0), capture.projector(0)
    motion = inverse(projector.pose) @ camera.pose
    half = np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
    rig = {"K1": camera.matrix - half, "K2": projector.matrix - half, "R": motion[:3, :3], "T": motion[:3, 3]}
    rig |= {"camera_size": (128, 128), "projector_size": (800, 800)}
    for pattern in ("all_black", "all_white", "lollipop_0"):
        encoded = np.rint(ffp.encode(capture.photograph(0, pattern)) * 255).astype(np.uint8)
        write_png(tmp_path / f"{pattern}.png", encoded)
    ffp.import_capture(
        tmp_path / "imported", rig,
        images={"black": tmp_path / "all_black.png", "white": tmp_path / "all_white.png", "x": tmp_path / "lollipop_0.png"},
        patterns={"x": sample / "patterns" / "lollipop_0.png"}, width=128,
    )  # fmt: skip
    made = ffp.Capture.open(tmp_path / "imported")
    assert made.pattern_names == ("black", "white", "x")
    between = inverse(made.camera(0).pose) @ made.projector(0).pose
    np.testing.assert_allclose(between, inverse(camera.pose) @ projector.pose, atol=1e-6)
    assert made.camera(0).cx == pytest.approx(camera.cx) and made.projector(0).fx == pytest.approx(
        projector.fx
    )
    bent = {**rig, "D1": [0.05, 0, 0, 0, 0]}
    with pytest.raises(ffp.Error, match="imported"):  # not over what is there
        ffp.import_capture(tmp_path / "imported", bent, images={"black": tmp_path / "all_black.png"})
