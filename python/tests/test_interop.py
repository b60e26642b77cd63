"""Captures and Gaussians in the forms of other programs, and back."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import ffprocams
import numpy as np
import pytest
from ffprocams import interop


def test_transforms_come_back(capture: ffprocams.Capture, tmp_path: Path) -> None:
    file = interop.to_transforms(capture, tmp_path / "out")
    cameras, projectors = interop.from_transforms(file)
    assert list(cameras) == list(projectors) == list(capture.view_ids)
    for view in capture.view_ids:
        for ours, theirs in (
            (capture.camera(view), cameras[view]),
            (capture.projector(view), projectors[view]),
        ):
            assert (ours.width, ours.height, ours.fx, ours.fy, ours.cx, ours.cy) == (
                theirs.width, theirs.height, theirs.fx, theirs.fy, theirs.cx, theirs.cy)  # fmt: skip
            assert np.allclose(ours.pose, theirs.pose, atol=1e-12)
    for folder in ("images", "masks"):
        assert sorted(p.stem for p in (file.parent / folder).iterdir()) == sorted(capture.view_ids)
    with pytest.raises(ffprocams.ArgumentError, match="not an empty folder"):
        interop.to_transforms(capture, tmp_path / "out")


def test_pictures_are_pictures(capture: ffprocams.Capture, tmp_path: Path) -> None:
    matplotlib = pytest.importorskip("matplotlib.image")
    interop.to_transforms(capture, tmp_path / "out")
    view = capture.view_ids[2]
    shown = matplotlib.imread(tmp_path / "out" / "images" / f"{view}.png")
    photograph = capture.photograph(view, capture.white)
    assert photograph is not None
    assert np.abs(shown - ffprocams.encode(photograph)).max() <= 0.5 / 255 + 1e-6


def test_damaged_transforms(capture: ffprocams.Capture, tmp_path: Path) -> None:
    file = interop.to_transforms(capture, tmp_path / "out")
    whole = json.loads(file.read_text())
    for change, word in (
        ({"fl_x": "long"}, "fl_x"),
        ({"k1": 0.1}, "k1"),
        ({"transform_matrix": [[1, 2], [3, 4]]}, "transform_matrix"),
        ({"transform_matrix": np.diag([1, 1, -1, 1]).tolist()}, "mirrors"),
        ({"transform_matrix": np.diag([2, 2, 2, 1]).tolist()}, "scales"),
        ({"camera_model": "EQUIRECTANGULAR"}, "EQUIRECTANGULAR, not a pinhole"),
        ({"camera_model": "OPENCV_FISHEYE"}, "undistort"),
        ({"is_fisheye": True}, "fisheye"),
        ({"latlong": True}, "latlong, not a pinhole"),
        ({"ftheta_p0": 0.0}, "ftheta_p0, not a pinhole"),
    ):
        file.write_text(json.dumps({**whole, "frames": [{**whole["frames"][0], **change}]}))
        with pytest.raises(ffprocams.ArgumentError, match=word):
            interop.from_transforms(file)
    file.write_text(json.dumps({**whole, "frames": [{**whole["frames"][0], "file_path": ".\\images\\a.png", "latlong": False}]}))
    assert list(interop.from_transforms(file)[0]) == ["a"]
    file.write_text(json.dumps({**whole, "frames": [whole["frames"][0]] * 2}))
    with pytest.raises(ffprocams.ArgumentError, match="have the same name"):
        interop.from_transforms(file)
    for text in ("{", "[1]", '{"frames": [3]}'):
        file.write_text(text)
        with pytest.raises(ffprocams.ArgumentError):
            interop.from_transforms(file)


def test_three_rows_are_a_pose(capture: ffprocams.Capture, tmp_path: Path) -> None:
    file = interop.to_transforms(capture, tmp_path / "out")
    wanted, whole = interop.from_transforms(file)[0], json.loads(file.read_text())
    for frame in whole["frames"]:
        frame["transform_matrix"] = frame["transform_matrix"][:3]
    file.write_text(json.dumps(whole))
    found = interop.from_transforms(file)[0]
    assert all(np.array_equal(found[name].pose, wanted[name].pose) for name in wanted)


def test_pictures_of_one_name_in_two_folders(capture: ffprocams.Capture, tmp_path: Path) -> None:
    file = interop.to_transforms(capture, tmp_path / "out")
    whole = json.loads(file.read_text())
    frames = [{**frame, "file_path": f"cam{k}/0001.png"} for k, frame in enumerate(whole["frames"][:2])]
    file.write_text(json.dumps({**whole, "frames": frames, "ffprocams_projectors": []}))
    assert list(interop.from_transforms(file)[0]) == ["cam0/0001", "cam1/0001"]


@pytest.fixture(scope="module")
def colmap(capture: ffprocams.Capture, gaussians: ffprocams.Gaussians, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return interop.to_colmap(capture, tmp_path_factory.mktemp("out") / "colmap", gaussians=gaussians)


def test_colmap_comes_back(capture: ffprocams.Capture, colmap: Path, tmp_path: Path) -> None:
    cameras, projectors = interop.from_colmap(colmap)
    assert list(cameras) == list(projectors) == list(capture.view_ids)
    for view in capture.view_ids:
        for ours, theirs in ((capture.camera(view), cameras[view]), (capture.projector(view), projectors[view])):
            assert (ours.width, ours.height, ours.fx, ours.fy, ours.cx, ours.cy) == (
                theirs.width, theirs.height, theirs.fx, theirs.fy, theirs.cx, theirs.cy)  # fmt: skip
            assert np.allclose(ours.pose, theirs.pose, atol=1e-6)  # a capture's poses are single precision
    cameras_, images = ((colmap / "sparse" / "0" / f"{name}.bin").read_bytes() for name in ("cameras", "images"))
    assert len(cameras_) == 8 + 24 + 32  # the views share a camera
    one = images[8:72]
    twice = struct.pack("<Q", 2) + b"".join(one + name + bytes(9) for name in (b"a/1.png", b"a/1.jpg"))
    for file, data, word in (
        ("cameras.bin", cameras_[:12] + b"\5" + cameras_[13:], "camera 1 is not a pinhole"),
        ("cameras.bin", cameras_[:12] + b"\3" + cameras_[13:] + struct.pack("<d", 0.1), "camera 1 has lens distortion"),
        ("images.bin", twice, r"'a/1\.png' and 'a/1\.jpg' have the same name 'a/1'"),
        ("cameras.bin", cameras_[:-1], "byte 32"),
        ("cameras.bin", cameras_[:32] + struct.pack("<d", np.nan) + cameras_[40:], "camera 1 is not finite"),
        ("cameras.bin", struct.pack("<Q", 0), "no camera 1"),
        ("images.bin", images[:12] + bytes(32) + images[44:], "theta000.png.*not a motion"),
        ("images.bin", images[:80], "no end"),
        ("images.bin", images[:92] + b"\xff" * 8 + images[100:], "ends within"),
        ("images.bin", b"", "byte 0"),
    ):
        for name, kept in (("cameras.bin", cameras_), ("images.bin", images)):
            (tmp_path / name).write_bytes(data if name == file else kept)
        with pytest.raises(ffprocams.ArgumentError, match=word) as caught:
            interop.from_colmap(tmp_path)
        assert str(tmp_path) in str(caught.value)


def test_colmap_folders_and_lenses_of_zero(colmap: Path, tmp_path: Path) -> None:
    model, sparse = colmap / "sparse" / "0", tmp_path / "sparse"
    sparse.mkdir()
    cameras, images = ((model / f"{name}.bin").read_bytes() for name in ("cameras", "images"))
    (sparse / "images.bin").write_bytes(images)
    wanted = interop.from_colmap(colmap)[0]
    for kind, numbers in ((1, 0), (4, 4), (6, 8)):
        lens = struct.pack("<i", kind), bytes(8 * numbers)
        (sparse / "cameras.bin").write_bytes(cameras[:12] + lens[0] + cameras[16:] + lens[1])
        found = interop.from_colmap(tmp_path)[0]
        assert list(found) == list(wanted) and all(found[name].K.tolist() == wanted[name].K.tolist() for name in wanted)
    for number in "01":
        (sparse / number).mkdir()
    with pytest.raises(ffprocams.ArgumentError, match="holds several models"):
        interop.from_colmap(tmp_path)
    for number in "01":
        (sparse / number).rmdir()
    (sparse / "cameras.bin").unlink()
    (sparse / "cameras.txt").write_text("1 PINHOLE 8 8 8 8 4 4\n")
    with pytest.raises(ffprocams.ArgumentError, match="is a text model: pinholes_from_pycolmap"):
        interop.from_colmap(tmp_path)


def test_colmap_as_colmap_reads_it(capture: ffprocams.Capture, colmap: Path) -> None:
    """The tracks: every point is projected by COLMAP to where its images say that it is, in the pictures' colours."""
    pycolmap = pytest.importorskip("pycolmap", reason="skipped: no pycolmap")
    model = pycolmap.Reconstruction(colmap / "sparse" / "0")
    assert model.num_cameras() == 1 and model.num_reg_images() == len(capture.view_ids)
    assert model.num_points3D() > 10000 and model.compute_mean_track_length() > 2
    model.update_point_3d_errors()
    assert model.compute_mean_reprojection_error() < 1e-4
    devices = ffprocams.pinholes_from_pycolmap(colmap / "projectors")
    view = capture.view_ids[1]
    assert np.allclose(devices[f"{view}.png"].pose, capture.projector(view).pose, atol=1e-6)


def test_points(capture: ffprocams.Capture, gaussians: ffprocams.Gaussians, colmap: Path, tmp_path: Path) -> None:
    """Both forms have the same points, which look like the photographs, and are seen from the front alone."""
    file = interop.to_transforms(capture, tmp_path / "out", gaussians=gaussians)
    raw = (file.parent / json.loads(file.read_text())["ply_file_path"]).read_bytes()
    head, body = raw.split(b"end_header\n", 1)
    points = np.frombuffer(body, [("at", "<f4", 3), ("colour", "u1", 3)])
    assert f"element vertex {len(points)}\n".encode() in head
    assert 0.5 * len(gaussians) < len(points) < len(gaussians)
    known = {tuple(row) for row in gaussians.centre.tolist()}
    assert all(tuple(row) in known for row in points["at"].tolist())

    data = (colmap / "sparse" / "0" / "points3D.bin").read_bytes()
    at, tracks = 8, []
    assert struct.unpack_from("<Q", data)[0] == len(points)
    for i, (centre, colour) in enumerate(points):
        number, *numbers, error, length = struct.unpack_from("<Q3d3BdQ", data, at)
        assert number == i + 1 and error == 0 and length > 0
        assert np.array_equal(numbers[:3], centre) and np.array_equal(numbers[3:], colour)
        tracks.append(np.frombuffer(data, "<u4", 2 * length, at + 51).reshape(-1, 2))
        at += 51 + 8 * length
    assert at == len(data)

    photograph, camera = capture.photograph(3, capture.white), capture.camera(3)
    assert photograph is not None
    rows = [i for i, track in enumerate(tracks) if 4 in track[:, 0]]  # image 4 is view 3
    x = (points["at"][rows] - camera.position) @ np.asarray(camera.pose)[:3, :3]
    column, row = (x[:, :2] / x[:, 2:] * camera.fx + (camera.cx, camera.cy)).astype(int).T
    assert np.abs(255 * ffprocams.encode(photograph)[row, column] - points["colour"][rows]).mean() < 20
    far = np.linalg.norm(camera.position - capture.centre)
    assert np.percentile(x[:, 2], 99) < far + 0.5 * capture.radius  # none on the object's back


def test_masks_and_depth(
    capture: ffprocams.Capture, gaussians: ffprocams.Gaussians, colmap: Path, tmp_path: Path
) -> None:
    file = interop.to_transforms(capture, tmp_path / "nerf", gaussians=gaussians)
    frame, view = json.loads(file.read_text())["frames"][3], capture.view_ids[3]
    depth = np.load(file.parent / frame["depth_file_path"]) / 1000
    raw = (colmap / "stereo" / "depth_maps" / f"{view}.png.geometric.bin").read_bytes()
    width, height, channels, rest = raw.split(b"&", 3)
    assert (int(height), int(width)) == depth.shape and channels == b"1"
    assert np.allclose(np.frombuffer(rest, "<f4").reshape(depth.shape), depth, rtol=1e-6)
    inside, shown = capture.coverage(3) > 0.99, depth > 0
    far = np.linalg.norm(np.asarray(capture.camera(3).pose)[:3, 3] - capture.centre)
    assert np.abs(depth[shown] - far).max() < 1.1 * capture.radius and shown[inside].mean() > 0.98
    masks = [(file.parent / frame["mask_path"]).read_bytes(), (colmap / "masks" / f"{view}.png").read_bytes()]
    assert masks[0] == masks[1]


def test_3dgs_comes_back(gaussians: ffprocams.Gaussians) -> None:
    back = ffprocams.Gaussians.from_3dgs(**gaussians.to_3dgs())
    for name in ("centre", "scale", "rotation", "opacity", "ambient"):
        assert np.allclose(getattr(back, name), getattr(gaussians, name), rtol=1e-4, atol=2e-5), name
    arguments = gaussians.to_gsplat()
    assert np.array_equal(arguments["scales"], gaussians.scale)
    assert np.allclose(arguments["colors"], ffprocams.encode(gaussians.ambient), atol=1e-5)
