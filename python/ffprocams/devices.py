"""Cameras and projectors, from OpenCV's matrices, dicts and .npz files, or COLMAP models.

The conventions are the library's: axes x right, y down, z forward; poses are device to world; pixel centres are at
integer + 0.5. OpenCV's calibration puts them at integers, so half a pixel is added to its principal points.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ._arguments import checked, expects
from ._call import PathLike
from ._library import ffi
from .errors import ErrorCode, FileFormatError, argument_error

Doubles = npt.NDArray[np.float64]


def rotation_of(rotation: npt.ArrayLike) -> Doubles:
    """A rotation matrix [3,3], given as such or as OpenCV's rvec: axis times angle in radians (Rodrigues' formula).
    Raises ArgumentError for matrices that scale or mirror."""
    given = np.asarray(rotation, np.float64)
    if given.shape == (3, 3):
        if not np.allclose(given @ given.T, np.eye(3), atol=1e-3) or np.linalg.det(given) < 0:
            raise argument_error("scales or mirrors: a rotation is needed", "rotation")
        return given
    if given.size != 3:
        raise argument_error(f"shape {given.shape} is neither a rotation [3,3] nor an rvec [3]", "rotation")
    axis = given.reshape(3)
    angle = float(np.linalg.norm(axis))
    if angle == 0:
        return np.eye(3)
    x, y, z = axis / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def quaternion_of(r: Doubles) -> Doubles:
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


def rigid(rotation: npt.ArrayLike, translation: npt.ArrayLike) -> Doubles:
    """The 4x4 rigid transform x -> R x + t, from a rotation ([3,3] or rvec) and a translation [3]."""
    out = np.eye(4)
    out[:3, :3] = rotation_of(rotation)
    way = np.asarray(translation, np.float64)
    expects(way.size == 3, "translation", "three numbers", translation)
    out[:3, 3] = way.reshape(3)
    return out


def inverse(motion: npt.ArrayLike) -> Doubles:
    """The inverse of a rigid 4x4 transform."""
    m = np.asarray(motion, np.float64)
    return rigid(m[:3, :3].T, -m[:3, :3].T @ m[:3, 3])


@checked
@dataclass(frozen=True, eq=False)
class Pinhole:
    """A camera without lens distortion, or a projector, modelled as a camera with light travelling the other way."""

    width: int  #: pixels
    height: int
    fx: float  #: pixels
    fy: float
    cx: float  #: pixels, centres at integer + 0.5; may lie outside the image
    cy: float
    pose: Doubles = field(default_factory=lambda: np.eye(4))  #: [4,4] device to world, rigid

    @property
    def K(self) -> Doubles:  # noqa: N802: as everybody calls it
        """[3,3] the calibration matrix: a point x of the device's frame appears at K x (homogeneous, in pixels, whose
        centres are at integer + 0.5; OpenCV's has principal points half a pixel smaller)."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]], np.float64)

    @classmethod
    def from_opencv(
        cls,
        matrix: npt.ArrayLike,
        rotation: npt.ArrayLike,
        translation: npt.ArrayLike,
        size: tuple[int, int],
        *,
        centres_at_integers: bool = True,
    ) -> Pinhole:
        """From the results of cv2.calibrateCamera and cv2.solvePnP.

        Args:
            matrix: [3,3] camera matrix, pixels.
            rotation: rvec [3] or R [3,3], world to device.
            translation: tvec [3], world to device, world units.
            size: width and height in pixels.
            centres_at_integers: whether the matrix puts pixel centres at integers, as OpenCV does.

        Raises:
            ArgumentError: an argument has a wrong shape, or the matrix has skew.
        """
        k = np.asarray(matrix, np.float64)
        if k.shape != (3, 3) or abs(k[0, 1]) > 1e-9 * abs(k[0, 0]) or not np.allclose(k[2], (0, 0, 1)):
            raise argument_error("not a 3x3 camera matrix without skew", "matrix")
        half = 0.5 if centres_at_integers else 0.0
        width, height = (int(n) for n in size)
        fx, fy, cx, cy = float(k[0, 0]), float(k[1, 1]), float(k[0, 2] + half), float(k[1, 2] + half)
        return cls(width, height, fx, fy, cx, cy, inverse(rigid(rotation, translation)))

    @classmethod
    def look_at(
        cls,
        eye: npt.ArrayLike,
        target: npt.ArrayLike,
        size: tuple[int, int],
        fov: float,
        up: npt.ArrayLike = (0, 0, 1),
    ) -> Pinhole:
        """A camera at ``eye`` looking at ``target``, world units; ``fov``: horizontal field of view, degrees.
        Raises ArgumentError for a target at ``eye``, or in the direction of ``up``, and an impossible ``fov``."""
        e, z = np.asarray(eye, np.float64), np.asarray(target, np.float64) - np.asarray(eye, np.float64)
        x = np.cross(z, np.asarray(up, np.float64))
        if not np.linalg.norm(x) > 1e-12:
            raise argument_error("the direction to it is zero or parallel to 'up'", "target")
        y = np.cross(z, x)
        axes = [a / np.linalg.norm(a) for a in (x, y, z)]
        expects(0 < fov < 180, "fov", "more than 0 and less than 180 degrees", fov)
        width, height = (int(n) for n in size)
        f = width / 2 / float(np.tan(np.radians(fov) / 2))
        return cls(width, height, f, f, width / 2, height / 2, rigid(np.stack(axes, 1), e))

    @property
    def matrix(self) -> Doubles:
        """[3,3] intrinsics, pixels, centres at integer + 0.5."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]])

    @property
    def position(self) -> Doubles:
        """[3] position of the device, world units."""
        return np.array(self.pose[:3, 3])

    def moved(self, motion: npt.ArrayLike) -> Pinhole:
        """The device moved by a 4x4 rigid transform of the world. Raises ArgumentError if it is not [4,4]."""
        matrix = np.asarray(motion, np.float64)
        expects(matrix.shape == (4, 4), "motion", "shape (4, 4)", matrix.shape)
        return replace(self, pose=matrix @ self.pose)

    def resized(self, width: int, height: int) -> Pinhole:
        """The same view at another size in pixels. Raises ArgumentError for a size below 1."""
        for name, side in (("width", width), ("height", height)):
            expects(side >= 1, name, "at least 1", side)
        x, y = width / self.width, height / self.height
        return replace(
            self, width=width, height=height, fx=self.fx * x, fy=self.fy * y, cx=self.cx * x, cy=self.cy * y
        )


def to_c(pinhole: Pinhole) -> Any:
    out = ffi.new("FfpPinhole *")
    fill(out, pinhole)
    return out


def fill(out: Any, pinhole: Pinhole) -> None:
    for name in ("width", "height", "fx", "fy", "cx", "cy"):
        setattr(out, name, getattr(pinhole, name))
    pose = np.asarray(pinhole.pose, np.float64)
    expects(pose.shape == (4, 4), "pose", "shape (4, 4)", pose.shape)
    out.pose = pose.ravel().tolist()


def from_c(p: Any) -> Pinhole:
    return Pinhole(p.width, p.height, p.fx, p.fy, p.cx, p.cy, np.array(list(p.pose)).reshape(4, 4))


# The names that calibrations use, in dicts and in .npz files.
_KEYS: dict[str, tuple[str, ...]] = {
    "camera_matrix": ("camera_matrix", "cam_int", "camK", "cam_K", "K_cam", "camIntrinsics", "cam1_intrinsics", "cameraMatrix1", "K1"),
    "camera_distortion": ("camera_distortion", "cam_dist", "camKc", "cam_kc", "camDistCoeffs", "cam1_distorsion", "cam1_distortion", "distCoeffs1", "D1"),
    "projector_matrix": ("projector_matrix", "proj_int", "prjK", "proj_K", "K_proj", "projIntrinsics", "cam2_intrinsics", "cameraMatrix2", "K2"),
    "projector_distortion": ("projector_distortion", "proj_dist", "prjKc", "proj_kc", "projDistCoeffs", "cam2_distorsion", "cam2_distortion", "distCoeffs2", "D2"),
    "rotation": ("rotation", "roration", "R", "rvec"),
    "translation": ("translation", "T", "t", "tvec"),
    "camera_size": ("camera_size", "cam_size", "imageSize"),
    "projector_size": ("projector_size", "proj_size", "prj_size"),
}  # fmt: skip

# Sizes in other forms: the names of width and height, and those of an array's shape, height before width.
_SIDES = {"camera_size": ("camW", "camH"), "projector_size": ("prjW", "prjH")}
_SHAPES = {"camera_size": "img_shape"}


@checked
@dataclass(frozen=True, eq=False)
class Calibration:
    """A camera and a projector fixed to each other. The world is the camera's frame.

    ``projector.pose`` is projector to camera. Distortion: OpenCV's k1 k2 p1 p2 k3, at most 5 numbers.
    """

    camera: Pinhole
    projector: Pinhole
    camera_distortion: Doubles = field(default_factory=lambda: np.zeros(5))
    projector_distortion: Doubles = field(default_factory=lambda: np.zeros(5))

    @classmethod
    def from_dict(
        cls,
        source: Mapping[str, Any],
        camera_size: tuple[int, int] | None = None,
        projector_size: tuple[int, int] | None = None,
        *,
        centres_at_integers: bool = True,
        where: str = "calibration",
    ) -> Calibration:
        """From the results of cv2.stereoCalibrate, under the names that calibration tools use for them.

        Matrices [3,3], distortions, rotation (R or rvec) and translation from camera to projector, X_p = R X_c + T,
        and sizes as width, height, which can be arguments instead (img_shape is height, width, as the program and
        procam-calibration write it). Other keys are ignored.

        Raises:
            ArgumentError: a field is missing, given twice or of a wrong shape, or a lens has more terms than k3.
        """
        found: dict[str, Any] = {}
        for what, names in _KEYS.items():
            there = [n for n in names if n in source]
            if len(there) > 1:
                raise argument_error(f"'{there[0]}' and '{there[1]}' mean the same: keep only one", where)
            if there:
                found[what] = source[there[0]]
        for what, given in (("camera_size", camera_size), ("projector_size", projector_size)):
            size = given if given is not None else _told_size(source, what, found.get(what), where)
            if size is not None:
                found[what] = size
        for what in (
            "camera_matrix",
            "projector_matrix",
            "rotation",
            "translation",
            "camera_size",
            "projector_size",
        ):
            if what not in found:
                names = _KEYS[what] + ((_SHAPES[what],) if what in _SHAPES else ()) + _SIDES.get(what, ())[:1]
                raise argument_error(f"no {what}: expected one of {', '.join(names)}", where)
        lens = {
            n: _lens(found.get(n, ()), f"{where}: {n}") for n in ("camera_distortion", "projector_distortion")
        }
        still: tuple[tuple[float, ...], ...] = ((0, 0, 0), (0, 0, 0))
        motions: dict[str, Any] = {"camera": still, "projector": (found["rotation"], found["translation"])}
        camera, projector = (
            Pinhole.from_opencv(
                found[f"{device}_matrix"],
                motion[0],
                motion[1],
                _size(found[f"{device}_size"], where),
                centres_at_integers=centres_at_integers,
            )
            for device, motion in motions.items()
        )
        return cls(camera, projector, **lens)

    @classmethod
    def load(
        cls,
        path: PathLike,
        camera_size: tuple[int, int] | None = None,
        projector_size: tuple[int, int] | None = None,
    ) -> Calibration:
        """From an .npz file (np.savez) or a JSON file with the keys of from_dict.
        Raises FileNotFoundError for a missing file, FileFormatError for a damaged one, ArgumentError for fields as from_dict does."""
        name = os.fspath(path)
        if name.endswith(".npz"):
            try:
                with np.load(path, allow_pickle=False) as arrays:
                    return cls.from_dict(dict(arrays), camera_size, projector_size, where=name)
            except (OSError, ValueError) as wrong:
                if isinstance(wrong, FileNotFoundError) or hasattr(wrong, "code"):
                    raise
                raise FileFormatError(f"cannot be read as .npz: {wrong} ({name})", ErrorCode.FILE, name) from wrong
        with open(path, encoding="utf-8") as file:
            try:
                parsed = json.load(file)
            except ValueError as wrong:
                raise FileFormatError(f"cannot be read as JSON: {wrong} ({name})", ErrorCode.FILE, name) from wrong
        if not isinstance(parsed, dict):
            raise FileFormatError(f"is not a JSON object ({name})", ErrorCode.FILE, name)
        return cls.from_dict(parsed, camera_size, projector_size, where=name)

    @property
    def distorted(self) -> bool:
        """True if a device has lens distortion: photographs must then go through import_capture."""
        return bool(np.any(self.camera_distortion) or np.any(self.projector_distortion))

    def turned(
        self, axis: npt.ArrayLike, point: npt.ArrayLike, angles: Sequence[float]
    ) -> list[tuple[Pinhole, Pinhole]]:
        """Camera and projector around an object that turned in front of them, one pair per stop, in the object's frame.

        The frame's origin is ``point`` and its z axis is ``axis``; it turns with the object.

        Args:
            axis: [3] direction of the turntable's axis, camera coordinates.
            point: [3] any point on the axis, camera coordinates, the calibration's unit.
            angles: rotation of the object at each stop, degrees, right-handed about the axis.

        Raises:
            ArgumentError: an argument is wrong, or the axis has no length.
        """
        length = np.linalg.norm(axis)
        expects(bool(length > 0), "axis", "a direction", axis)
        z = np.asarray(axis, np.float64) / length
        x = np.cross((0.0, 1.0, 0.0) if abs(z[1]) < 0.9 else (1.0, 0.0, 0.0), z)
        x /= np.linalg.norm(x)
        frame = inverse(rigid(np.stack([x, np.cross(z, x), z], 1), point))  # camera to object at angle 0
        turns = [rigid((0, 0, -np.radians(a)), (0, 0, 0)) @ frame for a in angles]
        return [(self.camera.moved(m), self.projector.moved(m)) for m in turns]

    def save(self, path: PathLike) -> None:
        """Writes JSON that import_capture and the program read (with the names of OpenCV's samples).
        Raises OSError if it cannot be written."""
        motion = inverse(self.projector.pose)
        written: dict[str, Any] = {"R": motion[:3, :3].tolist(), "T": motion[:3, 3:].tolist()}
        devices = ((1, self.camera, self.camera_distortion), (2, self.projector, self.projector_distortion))
        for number, device, lens in devices:
            k = device.matrix - [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]]
            written[f"cam{number}_intrinsics"] = k.tolist()
            written[f"cam{number}_distorsion"] = [np.asarray(lens).tolist()]
        with open(path, "w", encoding="utf-8") as file:
            json.dump(written, file, indent=1)


def _size(given: Any, where: str) -> tuple[int, int]:
    size = np.asarray(given).reshape(-1)
    if size.size != 2 or not np.all(size >= 1):
        raise argument_error("a size is width and height in pixels", where)
    return int(size[0]), int(size[1])


def _told_size(source: Mapping[str, Any], what: str, plain: Any, where: str) -> tuple[int, int] | None:
    """The width and height that the source gives, in one form or in several that must agree."""
    told = [] if plain is None else [_size(plain, where)]
    if all(key in source for key in _SIDES[what]):
        told.append(_size([np.asarray(source[key]).item() for key in _SIDES[what]], where))
    if _SHAPES.get(what) in source:
        height, width = _size(source[_SHAPES[what]], where)
        told.append((width, height))
    if any(size != told[0] for size in told):
        raise argument_error(f"{what} is given in several ways that differ: {told}", where)
    return told[0] if told else None


def _lens(given: Any, where: str) -> Doubles:
    lens = np.zeros(5)
    numbers = np.asarray(given, np.float64).reshape(-1)
    if np.any(numbers[5:]):
        raise argument_error("lens coefficients beyond k1 k2 p1 p2 k3 are not supported", where)
    lens[: min(5, numbers.size)] = numbers[:5]
    return lens


@checked
def pinholes_from_pycolmap(model: Any) -> dict[str, Pinhole]:
    """The devices of a COLMAP model, by the names of their images.

    Args:
        model: a pycolmap.Reconstruction, or the folder of one (which requires pycolmap). Its cameras must be PINHOLE or
            SIMPLE_PINHOLE: undistort the images first (COLMAP's image_undistorter), or give the folder of the text
            model to import_capture, which removes lens distortion.

    Raises:
        ArgumentError: a camera has lens distortion.
        ImportError: a folder is given, and pycolmap is not installed.
    """
    if isinstance(model, (str, os.PathLike)):
        import pycolmap

        model = pycolmap.Reconstruction(os.fspath(model))
    out: dict[str, Pinhole] = {}
    for image in model.images.values():
        camera = model.cameras[image.camera_id]
        kind = getattr(camera.model, "name", str(camera.model))
        if kind not in ("PINHOLE", "SIMPLE_PINHOLE"):
            raise argument_error(
                f"camera {image.camera_id} is {kind}: expected PINHOLE or SIMPLE_PINHOLE", image.name
            )
        motion = image.cam_from_world  # a method since pycolmap 3.12
        rows = np.asarray((motion() if callable(motion) else motion).matrix())
        size = (camera.width, camera.height)
        out[image.name] = Pinhole.from_opencv(
            camera.calibration_matrix(), rows[:, :3], rows[:, 3], size, centres_at_integers=False
        )
    return out
