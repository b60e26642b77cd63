"""Captures in the forms of other programs: nerfstudio's transforms.json and COLMAP's text files.

Both hold one photograph of each view, with its camera and mask, and depth if Gaussians are given to draw it from.
A capture's projectors have no place in either: they are written as further frames or images whose name begins with
"projector", without a photograph, so that poses come back complete.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ._call import PathLike
from ._pixels import Array, Floats, encode
from .capture import Capture
from .devices import Pinhole
from .errors import argument_error
from .gaussians import Gaussians, gaussians_of
from .renderer import Renderer

_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])  # nerfstudio's cameras: y up, z backwards


def _png(path: Path, picture: Array) -> None:
    """[height,width,3 or 4] or [height,width], uint8 or uint16."""
    kinds = {2: 0, 3: 2}
    colour = 6 if picture.ndim == 3 and picture.shape[2] == 4 else kinds[picture.ndim]
    rows = (
        np.ascontiguousarray(picture, picture.dtype.newbyteorder(">"))
        .reshape(len(picture), -1)
        .view(np.uint8)
    )
    raw = np.concatenate((np.zeros((len(rows), 1), np.uint8), rows), 1).tobytes()

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", picture.shape[1], picture.shape[0], 8 * picture.itemsize, colour, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")
    )


def _new_folder(folder: PathLike) -> Path:
    path = Path(folder)
    if path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise argument_error(f"{path} exists already and is not an empty folder", "folder")
    (path / "images").mkdir(parents=True, exist_ok=True)
    return path


def _photographs(capture: Capture, pattern: str | None, folder: Path) -> list[str]:
    """Writes a photograph of each view, and gives their names."""
    name, names = pattern or capture.white, []
    for view in capture.view_ids:
        photograph = capture.photograph(view, name)
        if photograph is None:
            raise argument_error(f"view {view} has no photograph under {name}", "pattern")
        names.append(f"images/{view}.png")
        _png(folder / names[-1], np.round(255 * encode(photograph)).astype(np.uint8))
    return names


def _masks(capture: Capture, paths: list[Path]) -> None:
    for i, path in enumerate(paths):
        path.parent.mkdir(exist_ok=True)
        _png(path, np.round(255 * capture.coverage(i)).astype(np.uint8))


def _depths(capture: Capture, gaussians: Gaussians | PathLike) -> Iterator[Floats]:
    """[height,width] of each view: camera z in world units, 0 off the object."""
    given, renderer = gaussians_of(gaussians), Renderer()
    for i in range(len(capture.view_ids)):
        yield renderer.aim(given, capture.camera(i), capture.projector(i)).map("depth")


def _numbers(p: Pinhole) -> dict[str, Any]:
    return {"fl_x": p.fx, "fl_y": p.fy, "cx": p.cx, "cy": p.cy, "w": p.width, "h": p.height}


def to_transforms(
    capture: Capture,
    folder: PathLike,
    *,
    pattern: str | None = None,
    gaussians: Gaussians | PathLike | None = None,
) -> Path:
    """Writes ``transforms.json`` with pictures and masks to a new or empty folder, and returns the file's path.

    Args:
        pattern: whose photographs are written; None: white.
        gaussians: the object's; then depth is written too, as ``depths/VIEW.npy`` in thousandths of the world's unit,
            which is what nerfstudio expects (its depth_unit_scale_factor is 0.001).
    """
    path = _new_folder(folder)
    frames: dict[str, list[dict[str, Any]]] = {"frames": [], "ffprocams_projectors": []}
    for i, name in enumerate(_photographs(capture, pattern, path)):
        view = capture.view_ids[i]
        for key, p in (("frames", capture.camera(i)), ("ffprocams_projectors", capture.projector(i))):
            frame = _numbers(p)
            frame["transform_matrix"] = (np.asarray(p.pose) @ _OPENGL).tolist()
            frame["file_path"] = name if key == "frames" else f"projector_{view}"
            frames[key].append(frame)
        frames["frames"][-1]["mask_path"] = f"masks/{view}.png"
    _masks(capture, [path / frame["mask_path"] for frame in frames["frames"]])
    if gaussians is not None:
        (path / "depths").mkdir()
        for frame, view, depth in zip(frames["frames"], capture.view_ids, _depths(capture, gaussians)):
            frame["depth_file_path"] = f"depths/{view}.npy"
            np.save(path / frame["depth_file_path"], 1000 * depth)
    out = path / "transforms.json"
    out.write_text(json.dumps({"camera_model": "OPENCV", **frames}, indent=1), encoding="utf-8")
    return out


def from_transforms(file: PathLike) -> tuple[dict[str, Pinhole], dict[str, Pinhole]]:
    """The cameras of a ``transforms.json`` by the file names of their pictures, and, if to_transforms wrote it, the
    projectors by the same names. Intrinsics may be each frame's own or the document's; lens distortion is refused."""
    path = Path(file)
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        return _frames(document, "frames"), _frames(document, "ffprocams_projectors")
    except (ValueError, TypeError, AttributeError) as wrong:
        raise argument_error(f"not a transforms.json: {wrong}", str(path)) from wrong


def _frames(document: dict[str, Any], key: str) -> dict[str, Pinhole]:
    out = {}
    for i, frame in enumerate(document.get(key, [])):
        where = f"{key}[{i}]"

        def number(name: str, frame: dict[str, Any] = frame, where: str = where) -> float:
            value = frame.get(name, document.get(name))
            if not isinstance(value, (int, float)) or not np.isfinite(value):
                raise argument_error("is missing or not a number", f"{where}.{name}")
            return float(value)

        for bent in ("k1", "k2", "k3", "k4", "p1", "p2"):
            if frame.get(bent, document.get(bent, 0)) != 0:
                raise argument_error("lens distortion must be removed first", f"{where}.{bent}")
        pose = np.asarray(frame.get("transform_matrix"), np.float64)
        if pose.shape != (4, 4) or not np.isfinite(pose).all():
            raise argument_error("is not a matrix of 4 x 4 numbers", f"{where}.transform_matrix")
        name = Path(str(frame.get("file_path", i))).stem
        out[name.removeprefix("projector_") if key != "frames" else name] = Pinhole(
            int(number("w")),
            int(number("h")),
            number("fl_x"),
            number("fl_y"),
            number("cx"),
            number("cy"),
            pose @ _OPENGL,
        )
    return out


def _quaternion(r: Array) -> Array:
    """w x y z of a rotation matrix, as the eigenvector of Bar-Itzhack's symmetric matrix (2000)."""
    k = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], 0, 0, 0],
            [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], 0, 0],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], 0],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], r[0, 0] + r[1, 1] + r[2, 2]],
        ]
    )
    x, y, z, w = np.linalg.eigh(k)[1][:, -1]  # of the lower triangle
    return np.array([w, x, y, z]) * (1 if w >= 0 else -1)


def to_colmap(
    capture: Capture,
    folder: PathLike,
    *,
    pattern: str | None = None,
    gaussians: Gaussians | PathLike | None = None,
) -> Path:
    """Writes COLMAP's ``cameras.txt``, ``images.txt`` and an empty ``points3D.txt`` with pictures and masks to a new or
    empty folder, and returns it. Camera 2 i + 1 is that of view i, camera 2 i + 2 its projector; from_colmap,
    ``import_capture`` and pinholes_from_pycolmap read them back.

    Args:
        pattern: whose photographs are written; None: white.
        gaussians: the object's; then depth is written too, as COLMAP's ``stereo/depth_maps/VIEW.png.geometric.bin``.
    """
    path = _new_folder(folder)
    cameras, images = [], []
    for i, name in enumerate(_photographs(capture, pattern, path)):
        shown = (Path(name).name, f"projector_{capture.view_ids[i]}.png")
        for k, p in enumerate((capture.camera(i), capture.projector(i))):
            number, pose = 2 * i + k + 1, np.asarray(p.pose)
            turn = pose[:3, :3].T
            cameras.append(f"{number} PINHOLE {p.width} {p.height} {p.fx!r} {p.fy!r} {p.cx!r} {p.cy!r}")
            numbers = (*_quaternion(turn), *(-turn @ pose[:3, 3]))
            images.append(f"{number} {' '.join(repr(float(v)) for v in numbers)} {number} {shown[k]}\n")
    _masks(
        capture, [path / "masks" / f"{view}.png.png" for view in capture.view_ids]
    )  # as mask_path wants them
    if gaussians is not None:
        (path / "stereo" / "depth_maps").mkdir(parents=True)
        for view, depth in zip(capture.view_ids, _depths(capture, gaussians)):
            head = f"{depth.shape[1]}&{depth.shape[0]}&1&".encode()
            out = path / "stereo" / "depth_maps" / f"{view}.png.geometric.bin"
            out.write_bytes(head + depth.astype("<f4").tobytes())
    (path / "cameras.txt").write_text("\n".join(cameras) + "\n", encoding="utf-8")
    (path / "images.txt").write_text("\n".join(images) + "\n", encoding="utf-8")
    (path / "points3D.txt").write_text("", encoding="utf-8")
    return path


def _fields(line: str, least: int, where: str) -> list[str]:
    fields = line.split()
    if len(fields) < least:
        raise argument_error(f"expected {least} fields, not {len(fields)}", where)
    return fields


def _floats(texts: list[str], where: str) -> list[float]:
    try:
        numbers = [float(t) for t in texts]
    except ValueError as wrong:
        raise argument_error(str(wrong), where) from wrong
    if not np.isfinite(numbers).all():
        raise argument_error("not finite", where)
    return numbers


def _colmap_cameras(path: Path) -> dict[str, list[float]]:
    """Width, height, fx, fy, cx, cy by number."""
    out: dict[str, list[float]] = {}
    for n, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        where = f"{path}:{n}"
        if not line.strip() or line.startswith("#"):
            continue
        number, kind, *rest = _fields(line, 4, where)
        if kind not in ("PINHOLE", "SIMPLE_PINHOLE"):
            raise argument_error(f"camera {number} is {kind}: expected PINHOLE or SIMPLE_PINHOLE", where)
        values = _floats(rest, where)
        if len(values) != (6 if kind == "PINHOLE" else 5):
            raise argument_error(f"{kind} has {len(values) - 2} parameters", where)
        out[number] = values if kind == "PINHOLE" else [*values[:3], *values[2:]]
    return out


def from_colmap(folder: PathLike) -> tuple[dict[str, Pinhole], dict[str, Pinhole]]:
    """The cameras of COLMAP's text files by the names of their images without suffix, and, if to_colmap wrote them, the
    projectors by the same names. Cameras with lens distortion are refused: undistort the images first."""
    path = Path(folder)
    cameras = _colmap_cameras(path / "cameras.txt")
    found: tuple[dict[str, Pinhole], dict[str, Pinhole]] = ({}, {})
    lines = (path / "images.txt").read_text(encoding="utf-8").splitlines()
    rows = [(n, line) for n, line in enumerate(lines, 1) if not line.startswith("#")]
    for n, line in rows[::2]:  # every other line lists points
        where = f"{path / 'images.txt'}:{n}"
        if not line.strip():
            continue
        fields = _fields(line, 10, where)
        if fields[8] not in cameras:
            raise argument_error(f"no camera {fields[8]}", where)
        (w, x, y, z), t = np.array(_floats(fields[1:5], where)), np.array(_floats(fields[5:8], where))
        length = w * w + x * x + y * y + z * z
        if not length > 1e-12:
            raise argument_error("a quaternion of length 0", where)
        turn = np.eye(3) + 2 / length * np.array(
            [[-y * y - z * z, x * y - w * z, x * z + w * y], [x * y + w * z, -x * x - z * z, y * z - w * x],
             [x * z - w * y, y * z + w * x, -x * x - y * y]])  # fmt: skip
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn.T, -turn.T @ t
        width, height, fx, fy, cx, cy = cameras[fields[8]]
        name = Path(" ".join(fields[9:])).stem
        lit = name.startswith("projector_")
        found[lit][name.removeprefix("projector_")] = Pinhole(int(width), int(height), fx, fy, cx, cy, pose)
    return found
