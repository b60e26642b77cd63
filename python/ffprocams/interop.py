"""Captures in the forms of other programs: nerfstudio's transforms.json and COLMAP's binary model.

Both hold one photograph of each view, with its camera and mask. If Gaussians are given, they also hold the depth drawn from
them, and their centres as the points from which trainers of splats and radiance fields start. Neither form has a place for
projectors: they are in a list or folder of their own, which other programs pass over.
"""

from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from ._arguments import checked
from ._call import PathLike
from ._pixels import Array, Floats, encode
from .capture import Capture
from .devices import Pinhole, inverse, quaternion_of, rigid, rotation_of
from .errors import ArgumentError, argument_error
from .gaussians import Gaussians, gaussians_of
from .renderer import Renderer

_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])  # nerfstudio's cameras: y up, z backwards
_PINHOLE = 1  # COLMAP's number of the model
# Its models without distortion, or whose distortion is zero: how many focal lengths, and how many numbers of distortion.
_COLMAP_MODELS = {0: (1, 0), _PINHOLE: (2, 0), 2: (1, 1), 3: (1, 2), 4: (2, 4), 6: (2, 8)}

# Of a view: the rows of the points that it sees, and their positions in pixels [...,2].
_Track = tuple[Array, Array]


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


def _masks(capture: Capture, folder: Path) -> None:
    (folder / "masks").mkdir()
    for i, view in enumerate(capture.view_ids):
        _png(folder / "masks" / f"{view}.png", np.round(255 * capture.coverage(i)).astype(np.uint8))


class _Points:
    """Gaussians as a cloud of points: which views see each of them, where, and in which colour.

    A view sees the points that are at most three standard deviations of their splat behind the depth drawn at their pixel;
    a point's colour is the mean of its pixels, as in COLMAP's models. Points that no view sees are left out.
    """

    def __init__(self, capture: Capture, gaussians: Gaussians | PathLike, pattern: str | None) -> None:
        self._capture, self._pattern, self._renderer = capture, pattern or capture.white, Renderer()
        self._gaussians = gaussians_of(gaussians)
        chosen = self._gaussians.opacity >= 0.5  # as in a map of depth
        self._centre = self._gaussians.centre[chosen].astype(np.float64)
        self._reach = 3 * self._gaussians.scale[chosen].max(1, initial=0)
        self._light = np.zeros((len(self._centre), 3))
        self._views = np.zeros(len(self._centre), np.int64)
        self._tracks: list[_Track] = []

    def look(self, view: int) -> Floats:
        """Finds the points that a view sees, and returns its depth [height,width]: camera z in world units, 0 off the
        object. To be called for all views in order."""
        camera = self._capture.camera(view)
        depth = self._renderer.aim(self._gaussians, camera, self._capture.projector(view)).map("depth")
        pose = np.asarray(camera.pose)
        x = (self._centre - pose[:3, 3]) @ pose[:3, :3]
        z = np.where(x[:, 2] > 0, x[:, 2], np.nan)
        at = x[:, :2] / z[:, None] * (camera.fx, camera.fy) + (camera.cx, camera.cy)
        inside = np.all((at >= 0) & (at < (camera.width, camera.height)), axis=1)
        column, row = np.where(inside[:, None], at, 0).astype(np.int64).T
        surface = depth[row, column]
        seen = np.flatnonzero(inside & (surface > 0) & (z - surface < self._reach))
        photograph = self._capture.photograph(view, self._pattern)
        assert photograph is not None  # _photographs wrote it
        self._light[seen] += encode(photograph)[row[seen], column[seen]]
        self._views[seen] += 1
        self._tracks.append((seen, at[seen]))
        return depth

    def found(self) -> tuple[Array, Array, list[_Track]]:
        """Centres [count,3] in world units, sRGB colours [count,3] uint8, and the track of each view."""
        kept = self._views > 0
        row = np.cumsum(kept) - 1
        colour = np.round(255 * self._light[kept] / self._views[kept, None]).astype(np.uint8)
        return self._centre[kept], colour, [(row[seen], at) for seen, at in self._tracks]


def _write_ply(path: Path, centre: Array, colour: Array) -> None:
    """Coloured points."""
    form = [(name, "<f4") for name in "xyz"] + [(name, "u1") for name in ("red", "green", "blue")]
    rows = np.empty(len(centre), form)
    for (name, _), column in zip(form, (*centre.T, *colour.T)):
        rows[name] = column
    head = "".join(f"property {'float' if kind == '<f4' else 'uchar'} {name}\n" for name, kind in form)
    text = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{head}end_header\n"
    path.write_bytes(text.encode() + rows.tobytes())


def _numbers(p: Pinhole) -> dict[str, Any]:
    return {"fl_x": p.fx, "fl_y": p.fy, "cx": p.cx, "cy": p.cy, "w": p.width, "h": p.height}


@checked
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
            which is what nerfstudio expects (its depth_unit_scale_factor is 0.001), and ``points.ply``, where its
            splatfacto starts (``ply_file_path``).

    Raises:
        ArgumentError: an argument is wrong, or the folder is not empty, or a view has no photograph under the pattern.
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
    _masks(capture, path)
    document: dict[str, Any] = {"camera_model": "OPENCV", **frames}
    if gaussians is not None:
        points = _Points(capture, gaussians, pattern)
        (path / "depths").mkdir()
        for i, frame in enumerate(frames["frames"]):
            frame["depth_file_path"] = f"depths/{capture.view_ids[i]}.npy"
            np.save(path / frame["depth_file_path"], 1000 * points.look(i))
        _write_ply(path / "points.ply", *points.found()[:2])
        document["ply_file_path"] = "points.ply"
    out = path / "transforms.json"
    out.write_text(json.dumps(document, indent=1), encoding="utf-8")
    return out


@checked
def from_transforms(file: PathLike) -> tuple[dict[str, Pinhole], dict[str, Pinhole]]:
    """The cameras of a ``transforms.json`` by the file names of their pictures, or by their paths without suffixes where
    file names repeat, and, if to_transforms wrote it, the projectors by the same names. Intrinsics may be each frame's own
    or the document's. Raises ArgumentError for lens distortion, cameras that are not pinholes, poses that scale or mirror,
    and pictures that are listed twice."""
    path = Path(file)
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        return _frames(document, "frames"), _frames(document, "ffprocams_projectors")
    except (ValueError, TypeError, AttributeError) as wrong:
        raise argument_error(f"not a transforms.json: {wrong}", str(path)) from wrong


# nerfstudio's words for cameras without distortion, or whose distortion is zero.
_PINHOLE_MODELS = ("PINHOLE", "SIMPLE_PINHOLE", "OPENCV", "RADIAL", "SIMPLE_RADIAL", "FULL_OPENCV", "PERSPECTIVE")


# Words of instant-ngp for others.
_OTHER_LENSES = ("is_fisheye", "latlong", "equirectangular", "orthographic", "ftheta_p0")


def _is_told(word: str, frame: dict[str, Any], document: dict[str, Any]) -> bool:
    """True of a word that is not false, or of a polynomial's term, which may be 0."""
    value = frame.get(word, document.get(word))
    return value is not None if word.startswith("ftheta") else bool(value)


def _names_of_pictures(paths: list[str]) -> list[str]:
    """File names without folder and suffix, or, if two are the same, paths without suffixes."""
    posix = [PurePosixPath(path.replace("\\", "/")) for path in paths]  # of Windows, too
    stems = [path.stem for path in posix]
    return stems if len(set(stems)) == len(stems) else [str(path.with_suffix("")) for path in posix]


def _check_new(out: dict[str, Pinhole], name: str, files: dict[str, str], where: str, file: str) -> None:
    if name in out:
        raise argument_error(f"the pictures {files[name]!r} and {file!r} have the same name {name!r}", where)


def _rotation(turn: Array, where: str) -> Array:
    try:
        return rotation_of(turn)
    except ArgumentError as wrong:
        raise argument_error("scales or mirrors: a rotation is needed", where) from wrong


def _frames(document: dict[str, Any], key: str) -> dict[str, Pinhole]:
    out: dict[str, Pinhole] = {}
    files: dict[str, str] = {}
    frames = document.get(key, [])
    names = _names_of_pictures([str(frame.get("file_path", i)) for i, frame in enumerate(frames)])
    for i, (frame, name) in enumerate(zip(frames, names)):
        where = f"{key}[{i}]"

        def number(name: str, frame: dict[str, Any] = frame, where: str = where) -> float:
            value = frame.get(name, document.get(name))
            if not isinstance(value, (int, float)) or not np.isfinite(value):
                raise argument_error("is missing or not a number", f"{where}.{name}")
            return float(value)

        model = frame.get("camera_model", document.get("camera_model", "PINHOLE"))
        other = next((word for word in _OTHER_LENSES if _is_told(word, frame, document)), None)
        if model not in _PINHOLE_MODELS or other:
            what = f"a camera with {other}" if other else f"{model}"
            raise argument_error(f"is {what}, not a pinhole: undistort the pictures first", f"{where}.camera_model")
        for bent in ("k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"):
            if frame.get(bent, document.get(bent, 0)) != 0:
                raise argument_error("lens distortion must be removed first", f"{where}.{bent}")
        pose = np.asarray(frame.get("transform_matrix"), np.float64)
        if pose.shape not in ((3, 4), (4, 4)) or not np.isfinite(pose).all():
            raise argument_error("is not a matrix of 3 x 4 or 4 x 4 numbers", f"{where}.transform_matrix")
        pose = rigid(_rotation(pose[:3, :3], f"{where}.transform_matrix"), pose[:3, 3])
        if key != "frames":
            name = str(Path(name).with_name(Path(name).name.removeprefix("projector_")))
        _check_new(out, name, files, f"{where}.file_path", str(frame.get("file_path", i)))
        files[name] = str(frame.get("file_path", i))
        out[name] = Pinhole(
            int(number("w")),
            int(number("h")),
            number("fl_x"),
            number("fl_y"),
            number("cx"),
            number("cy"),
            pose @ _OPENGL,
        )
    return out


def _write_model(
    folder: Path,
    devices: dict[str, Pinhole],
    points: tuple[Array, Array, list[_Track]] = (np.empty((0, 3)), np.empty((0, 3), np.uint8), []),
) -> None:
    """COLMAP's ``cameras.bin``, ``images.bin`` and ``points3D.bin`` (https://colmap.github.io/format.html): PINHOLE devices
    by the names of their images, those of equal intrinsics as one camera, and what _Points.found gave."""
    folder.mkdir(parents=True)
    centre, colour, tracks = points
    cameras: dict[bytes, int] = {}
    images = [struct.pack("<Q", len(devices))]
    none = np.empty(0, np.int64), np.empty((0, 2))
    for i, (name, p) in enumerate(devices.items()):
        camera = struct.pack("<iQQ4d", _PINHOLE, p.width, p.height, p.fx, p.fy, p.cx, p.cy)
        number = cameras.setdefault(camera, len(cameras) + 1)
        pose = np.asarray(p.pose)
        turn = pose[:3, :3].T
        rows, at = tracks[i] if tracks else none
        seen = np.empty(len(rows), [("x", "<f8"), ("y", "<f8"), ("point", "<u8")])
        seen["x"], seen["y"], seen["point"] = at[:, 0], at[:, 1], rows + 1
        images.append(struct.pack("<I7dI", i + 1, *quaternion_of(turn), *(-turn @ pose[:3, 3]), number))
        images.append(name.encode() + b"\0" + struct.pack("<Q", len(rows)) + seen.tobytes())
    kinds = [struct.pack("<I", number) + camera for camera, number in cameras.items()]
    (folder / "cameras.bin").write_bytes(struct.pack("<Q", len(kinds)) + b"".join(kinds))
    (folder / "images.bin").write_bytes(b"".join(images))

    point = np.concatenate([rows for rows, _ in tracks] or [none[0]])
    track = [np.stack((np.full(len(r), i + 1), np.arange(len(r))), 1) for i, (r, _) in enumerate(tracks)]
    pairs = np.concatenate(track or [none[1]])[np.argsort(point, kind="stable")].astype("<u4").tobytes()
    length = np.bincount(point, minlength=len(centre))
    form = [("number", "<u8"), ("at", "<f8", 3), ("colour", "u1", 3), ("error", "<f8"), ("length", "<u8")]
    heads = np.zeros(len(centre), form)
    heads["number"], heads["at"], heads["colour"] = np.arange(1, len(centre) + 1), centre, colour
    heads["length"] = length
    ends = 8 * np.cumsum(length)
    whole = b"".join(h.tobytes() + pairs[end - 8 * n : end] for h, end, n in zip(heads, ends, length))
    (folder / "points3D.bin").write_bytes(struct.pack("<Q", len(centre)) + whole)


@checked
def to_colmap(
    capture: Capture,
    folder: PathLike,
    *,
    pattern: str | None = None,
    gaussians: Gaussians | PathLike | None = None,
) -> Path:
    """Writes COLMAP's binary model ``sparse/0`` with ``images/VIEW.png`` and ``masks/VIEW.png`` to a new or empty folder,
    and returns it. ``projectors`` is a model too, of the projectors by the same names. from_colmap reads both back.

    Args:
        pattern: whose photographs are written; None: white.
        gaussians: the object's; then the model has their centres as points, with colours and tracks, and depth is written
            as COLMAP's ``stereo/depth_maps/VIEW.png.geometric.bin``. Trainers that start from points need them.

    Raises:
        ArgumentError: an argument is wrong, or the folder is not empty, or a view has no photograph under the pattern.
    """
    path = _new_folder(folder)
    names = [Path(name).name for name in _photographs(capture, pattern, path)]
    _masks(capture, path)
    views = range(len(names))
    found = {}
    if gaussians is not None:
        points = _Points(capture, gaussians, pattern)
        (path / "stereo" / "depth_maps").mkdir(parents=True)
        for i, name in enumerate(names):
            depth = points.look(i)
            head = f"{depth.shape[1]}&{depth.shape[0]}&1&".encode()
            out = path / "stereo" / "depth_maps" / f"{name}.geometric.bin"
            out.write_bytes(head + depth.astype("<f4").tobytes())
        found["points"] = points.found()
    _write_model(path / "sparse" / "0", {names[i]: capture.camera(i) for i in views}, **found)
    _write_model(path / "projectors", {names[i]: capture.projector(i) for i in views})
    return path


class _Reader:
    """A binary file from its beginning; what goes beyond its end is an error."""

    def __init__(self, path: Path) -> None:
        self.path, self.data, self.at = str(path), path.read_bytes(), 0

    def take(self, form: str) -> tuple[Any, ...]:
        at, self.at = self.at, self.at + struct.calcsize(form)
        if self.at > len(self.data):
            raise argument_error(f"ends within a record that starts at byte {at}", self.path)
        return struct.unpack_from(form, self.data, at)

    def name(self) -> str:
        end = self.data.find(b"\0", self.at)
        if end < 0:
            raise argument_error(f"the name at byte {self.at} has no end", self.path)
        at, self.at = self.at, end + 1
        return self.data[at:end].decode(errors="replace")


def _pose(reader: _Reader, name: str, numbers: tuple[float, ...]) -> Array:
    """Device to world, of a world-to-device quaternion w x y z and translation."""
    (w, x, y, z), t = np.array(numbers[:4]), np.array(numbers[4:])
    length = w * w + x * x + y * y + z * z
    if not length > 1e-12 or not np.isfinite(numbers).all():
        raise argument_error(f"the pose of image {name!r} is not a motion", reader.path)
    turn = np.eye(3) + 2 / length * np.array(
        [[-y * y - z * z, x * y - w * z, x * z + w * y], [x * y + w * z, -x * x - z * z, y * z - w * x],
         [x * z - w * y, y * z + w * x, -x * x - y * y]])  # fmt: skip
    return inverse(rigid(turn, t))


def _read_model(folder: Path) -> dict[str, Pinhole]:
    """The devices of a binary model by the names of their images without suffix."""
    cameras: dict[int, tuple[int, int, float, float, float, float]] = {}
    out: dict[str, Pinhole] = {}
    files: dict[str, str] = {}
    if (folder / "cameras.txt").is_file() and not (folder / "cameras.bin").is_file():
        raise argument_error(
            "is a text model: pinholes_from_pycolmap reads it, or colmap model_converter --output_type BIN makes it binary",
            str(folder),
        )
    reader = _Reader(folder / "cameras.bin")
    for _ in range(reader.take("<Q")[0]):
        number, kind, width, height = reader.take("<IiQQ")
        if kind not in _COLMAP_MODELS:
            raise argument_error(f"camera {number} is not a pinhole: undistort the images first", reader.path)
        focal, bent = _COLMAP_MODELS[kind]
        lens = reader.take(f"<{focal + 2 + bent}d")
        fx, fy, (cx, cy) = lens[0], lens[focal - 1], lens[focal : focal + 2]
        if any(lens[focal + 2 :]):
            raise argument_error(f"camera {number} has lens distortion: undistort the images first", reader.path)
        if not np.isfinite((fx, fy, cx, cy)).all():
            raise argument_error(f"camera {number} is not finite", reader.path)
        cameras[number] = (width, height, fx, fy, cx, cy)
    reader = _Reader(folder / "images.bin")
    for _ in range(reader.take("<Q")[0]):
        _, *numbers, camera = reader.take("<I7dI")
        name = reader.name()
        reader.take(f"<{24 * min(reader.take('<Q')[0], len(reader.data))}x")  # its points
        if camera not in cameras:
            raise argument_error(f"image {name!r}: no camera {camera}", reader.path)
        pose = _pose(reader, name, tuple(numbers))
        key = str(PurePosixPath(name).with_suffix(""))
        _check_new(out, key, files, reader.path, name)
        files[key] = name
        out[key] = Pinhole(*cameras[camera], pose)
    return out


@checked
def from_colmap(folder: PathLike) -> tuple[dict[str, Pinhole], dict[str, Pinhole]]:
    """The cameras of a binary COLMAP model (``sparse/0`` or ``sparse`` in the folder, or the folder itself) by the names of
    their images without suffix, and, if to_colmap wrote them, the projectors by the same names. Raises ArgumentError for
    lens distortion (undistort the images first), for images of the same name, for several models, for damaged files, and for text models, which
    pinholes_from_pycolmap reads; FileNotFoundError for missing files."""
    path = Path(folder)
    places = (path / "sparse" / "0", path / "sparse")
    if places[0].is_dir() and (path / "sparse" / "1").is_dir():
        raise argument_error("holds several models: name the folder of one, such as sparse/0", str(path / "sparse"))
    cameras = _read_model(next((place for place in places if place.is_dir()), path))
    return cameras, _read_model(path / "projectors") if (path / "projectors").is_dir() else {}
