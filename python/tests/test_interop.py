"""Captures and Gaussians in the forms of other programs, and back."""

from __future__ import annotations

import json
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
    ):
        file.write_text(json.dumps({**whole, "frames": [{**whole["frames"][0], **change}]}))
        with pytest.raises(ffprocams.ArgumentError, match=word):
            interop.from_transforms(file)
    for text in ("{", "[1]", '{"frames": [3]}'):
        file.write_text(text)
        with pytest.raises(ffprocams.ArgumentError):
            interop.from_transforms(file)


def test_colmap_text(capture: ffprocams.Capture, tmp_path: Path) -> None:
    folder = interop.to_colmap(capture, tmp_path / "out")
    lines = [line for line in (folder / "images.txt").read_text().split("\n") if line]
    assert len(lines) == 2 * len(capture.view_ids)
    for i, line in enumerate(lines):
        w, x, y, z, *t = (float(v) for v in line.split()[1:8])
        turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])  # fmt: skip
        pose = np.asarray((capture.projector if i % 2 else capture.camera)(i // 2).pose)
        assert np.allclose(turn, pose[:3, :3].T, atol=1e-6)
        assert np.allclose(-turn.T @ t, pose[:3, 3], atol=1e-6)


def test_colmap_comes_back(capture: ffprocams.Capture, tmp_path: Path) -> None:
    folder = interop.to_colmap(capture, tmp_path / "out")
    cameras, projectors = interop.from_colmap(folder)
    assert list(cameras) == list(projectors) == list(capture.view_ids)
    for view in capture.view_ids:
        for ours, theirs in ((capture.camera(view), cameras[view]), (capture.projector(view), projectors[view])):
            assert (ours.width, ours.height, ours.fx, ours.fy, ours.cx, ours.cy) == (
                theirs.width, theirs.height, theirs.fx, theirs.fy, theirs.cx, theirs.cy)  # fmt: skip
            assert np.allclose(ours.pose, theirs.pose, atol=1e-6)  # a capture's poses are single precision
    first = (folder / "images.txt").read_text().split("\n", 1)[0]
    whole = (folder / "cameras.txt").read_text()
    for file, text, word in (
        ("cameras.txt", whole.replace("PINHOLE", "OPENCV", 1), "OPENCV"),
        ("cameras.txt", whole.replace("PINHOLE 128", "PINHOLE wide", 1), "cameras.txt:1"),
        ("cameras.txt", "7 PINHOLE 8 8 1 1 1 1", "no camera"),
        ("images.txt", "1 0 0 0 0 1 1 1 1 a.png", "length 0"),
        ("images.txt", "1 2 3", "10 fields"),
        ("images.txt", first.replace(first.split()[2], "nan"), "finite"),
    ):
        kept = (folder / file).read_text()
        (folder / file).write_text(text)
        with pytest.raises(ffprocams.ArgumentError, match=word):
            interop.from_colmap(folder)
        (folder / file).write_text(kept)


def test_masks_and_depth(capture: ffprocams.Capture, gaussians: ffprocams.Gaussians, tmp_path: Path) -> None:
    file = interop.to_transforms(capture, tmp_path / "nerf", gaussians=gaussians)
    folder = interop.to_colmap(capture, tmp_path / "colmap", gaussians=gaussians)
    frame, view = json.loads(file.read_text())["frames"][3], capture.view_ids[3]
    depth = np.load(file.parent / frame["depth_file_path"]) / 1000
    raw = (folder / "stereo" / "depth_maps" / f"{view}.png.geometric.bin").read_bytes()
    width, height, channels, rest = raw.split(b"&", 3)
    assert (int(height), int(width)) == depth.shape and channels == b"1"
    assert np.allclose(np.frombuffer(rest, "<f4").reshape(depth.shape), depth, rtol=1e-6)
    inside, shown = capture.coverage(3) > 0.99, depth > 0
    far = np.linalg.norm(np.asarray(capture.camera(3).pose)[:3, 3] - capture.centre)
    assert np.abs(depth[shown] - far).max() < 1.1 * capture.radius and shown[inside].mean() > 0.98
    masks = [(file.parent / frame["mask_path"]).read_bytes(), (folder / "masks" / f"{view}.png.png").read_bytes()]
    assert masks[0] == masks[1]


def test_3dgs_comes_back(gaussians: ffprocams.Gaussians) -> None:
    back = ffprocams.Gaussians.from_3dgs(**gaussians.to_3dgs())
    for name in ("centre", "scale", "rotation", "opacity", "ambient"):
        assert np.allclose(getattr(back, name), getattr(gaussians, name), rtol=1e-4, atol=2e-5), name
    arguments = gaussians.to_gsplat()
    assert np.array_equal(arguments["scales"], gaussians.scale)
    assert np.allclose(arguments["colors"], ffprocams.encode(gaussians.ambient), atol=1e-5)
