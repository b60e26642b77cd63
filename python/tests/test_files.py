"""Files for other programs, read by other programs' libraries: trimesh, pygltflib and Open3D, each where it is installed."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import ffprocams as ffp
import numpy as np
import pytest

VIEW = "path_0_theta000"


@pytest.fixture(scope="module")
def files(gaussians: ffp.Reconstructed, sample: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """splats.glb, mesh.glb and mesh.obj of the sample, and the maps of a view."""
    found = os.environ.get("FFPROCAMS_PROGRAM") or shutil.which("ffprocams")
    if not found:
        pytest.skip("skipped: no program `ffprocams` (FFPROCAMS_PROGRAM)")
    folder = tmp_path_factory.mktemp("files")
    gaussians.save(folder / "spot.ply")
    of: list[str | Path] = ["-c", sample]
    commands: tuple[list[str | Path], ...] = (
        ["export", folder / "spot.ply", "-o", folder / "splats.glb"],
        ["export", folder / "spot.ply", *of, "--mesh", "--resolution", "96", "-o", folder / "mesh.glb"],
        ["export", folder / "spot.ply", *of, "--mesh", "--resolution", "96", "-o", folder / "mesh.obj"],
        ["map", folder / "spot.ply", *of, "-v", VIEW, "-o", folder],
    )
    for arguments in commands:
        subprocess.run([found, *arguments], check=True, capture_output=True)
    return folder


def test_trimesh(files: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    solid = trimesh.load(files / "mesh.obj", force="mesh", process=False)
    _, faces = np.unique(np.sort(solid.edges, axis=1), axis=0, return_counts=True)
    assert np.all(faces == 2) and solid.is_watertight and solid.volume > 0
    textured = trimesh.load(files / "mesh.glb", force="mesh", process=False)
    assert len(textured.faces) == len(solid.faces)
    assert np.allclose(textured.bounds, solid.bounds, atol=1e-5)
    warps = [
        trimesh.load(files / f"{VIEW}_warp.{kind}", force="mesh", process=False) for kind in ("obj", "glb")
    ]
    for warp in warps:  # trimesh's v counts from below in both
        assert np.all(np.abs(warp.visual.uv - 0.5) <= 0.5)
    corners = [
        np.hstack([warp.triangles[:, :, :2].reshape(-1, 2), warp.visual.uv[warp.faces].reshape(-1, 2)])
        for warp in warps
    ]
    assert np.allclose(corners[0], corners[1], atol=2e-6)


def test_pygltflib(files: Path) -> None:
    pygltflib = pytest.importorskip("pygltflib")
    for name in ("splats.glb", "mesh.glb", f"{VIEW}_warp.glb"):
        model = pygltflib.GLTF2().load(files / name)
        (primitive,) = model.meshes[0].primitives
        position = model.accessors[primitive.attributes.POSITION]
        view = model.bufferViews[position.bufferView]
        values = np.frombuffer(model.binary_blob(), "<f4", 3 * position.count, view.byteOffset).reshape(-1, 3)
        assert np.array_equal(values.min(axis=0), np.float32(position.min))
        assert np.array_equal(values.max(axis=0), np.float32(position.max))


def test_open3d(files: Path) -> None:
    open3d = pytest.importorskip("open3d")
    solid, textured = (open3d.io.read_triangle_mesh(str(files / f"mesh.{kind}")) for kind in ("obj", "glb"))
    assert solid.is_edge_manifold(allow_boundary_edges=False) and solid.is_orientable()
    assert len(solid.triangles) == len(textured.triangles) > 1000
    warp = open3d.io.read_triangle_mesh(str(files / f"{VIEW}_warp.glb"))
    assert warp.has_triangle_uvs() and len(warp.triangles) > 1000
