"""Relightable 3D Gaussians, and the weights that predict them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ._arguments import checked, expects, one_of
from ._call import Call, Handle, Keep, PathLike, ProgressOption, holding, some
from ._library import ffi, lib
from ._pixels import Array, Floats, floats_at
from .capture import Capture, capture_of, record, three
from .devices import quaternion_of, rotation_of
from .errors import argument_error

FRAMINGS = {
    "cover": lib.FFP_FRAMING_COVER,
    "contain": lib.FFP_FRAMING_CONTAIN,
    "stretch": lib.FFP_FRAMING_STRETCH,
    "pixel": lib.FFP_FRAMING_PIXEL,
}
_UPS = {"z": lib.FFP_UP_Z, "y": lib.FFP_UP_Y, "-y": lib.FFP_UP_MINUS_Y}
_ORBITS = {
    "camera": lib.FFP_ORBIT_CAMERA,
    "projector": lib.FFP_ORBIT_PROJECTOR,
    "object": lib.FFP_ORBIT_OBJECT,
}
_WIDTHS = {"centre": 3, "scale": 3, "rotation": 4, "opacity": 1, "albedo": 3, "roughness": 1, "ambient": 3, "scattered": 3}  # fmt: skip


@dataclass
class ExportStats:
    """Contents of an exported file."""

    splats: int
    triangles: int
    bytes: int


@dataclass
class PageStats:
    """Contents of a page."""

    gaussians: int
    bytes: int
    patterns: int
    photographs: int


@checked
class Gaussians(Handle):
    """Splats with material properties. Arrays have one row per Gaussian.

    Arrays are views of the library's memory: nothing is copied, they keep it alive, and they may be written to (new
    values are not checked: see check).
    """

    @classmethod
    def load(cls, path: PathLike) -> Gaussians:
        """Reads a PLY with the property names of 3DGS, plus base_color_0..2 and roughness; or the plain splats of
        other programs (PLY, SPZ, glTF).
        Raises MissingFileError or FileFormatError for a file that is missing or damaged."""
        keep = Keep()
        with Call() as call:
            made = lib.ffp_gaussians_open(call.context, keep.path(path), ffi.NULL, call.error)
            return cls(call.take(made, lib.ffp_gaussians_close))

    @classmethod
    def from_bytes(cls, contents: bytes, name: str = "contents") -> Gaussians:
        """As load, from a file's contents. name: what messages call it; its ending tells .splat and .gltf.
        Raises FileFormatError for damaged contents."""
        keep = Keep()
        with Call() as call:
            made = lib.ffp_gaussians_open(call.context, keep.text(name), keep.contents(contents), call.error)
            return cls(call.take(made, lib.ffp_gaussians_close))

    @classmethod
    def from_arrays(
        cls,
        centre: npt.ArrayLike,
        scale: npt.ArrayLike,
        rotation: npt.ArrayLike,
        opacity: npt.ArrayLike,
        albedo: npt.ArrayLike,
        roughness: npt.ArrayLike,
        ambient: npt.ArrayLike,
        scattered: npt.ArrayLike | None = None,
    ) -> Gaussians:
        """Copies the arrays and checks them (finite, in range), normalising rotations. Errors name array and row.

        Args:
            centre: [count,3] world units.
            scale: [count,3] standard deviations along the rotated axes, world units, above 0.
            rotation: [count,4] quaternions w x y z: the splat's axes to the world.
            opacity: [count] in [0,1].
            albedo: [count,3] linear diffuse albedo.
            roughness: [count] in [0,1].
            ambient: [count,3] linear radiance shown when the projector is black.
            scattered: [count,3] linear radiance that white adds in other ways than by its direct ray. None: none.

        Raises:
            ArgumentError: a shape or a number is wrong.
        """
        return cls(_copy((centre, scale, rotation, opacity, albedo, roughness, ambient, scattered)))

    def _array(self, name: str) -> Floats:
        arrays, width = lib.ffp_gaussians_arrays(self._pointer), _WIDTHS[name]
        shape = (arrays.count,) if width == 1 else (arrays.count, width)
        return floats_at(getattr(arrays, name), shape, self, writable=True)

    @property
    def centre(self) -> Floats:
        """[count,3] world units."""
        return self._array("centre")

    @property
    def scale(self) -> Floats:
        """[count,3] standard deviations along the rotated axes, world units."""
        return self._array("scale")

    @property
    def rotation(self) -> Floats:
        """[count,4] unit quaternions w x y z: the splat's axes to the world."""
        return self._array("rotation")

    @property
    def opacity(self) -> Floats:
        """[count] in [0,1]."""
        return self._array("opacity")

    @property
    def albedo(self) -> Floats:
        """[count,3] linear diffuse albedo."""
        return self._array("albedo")

    @property
    def roughness(self) -> Floats:
        """[count] in [0,1]."""
        return self._array("roughness")

    @property
    def ambient(self) -> Floats:
        """[count,3] linear radiance shown when the projector is black."""
        return self._array("ambient")

    @property
    def scattered(self) -> Floats:
        """[count,3] linear radiance that white adds in other ways than by its direct ray; it follows the pattern's mean.
        Where all is 0, numbers written here count in copies alone."""
        return self._array("scattered")

    def arrays(self) -> dict[str, Floats]:
        """All arrays by name, as for from_arrays."""
        return {name: self._array(name) for name in _WIDTHS}

    def __getitem__(self, rows: slice | npt.ArrayLike) -> Gaussians:
        """A copy of some of the Gaussians: a slice, a mask [count] of bool, or indices."""
        if isinstance(rows, (int, np.integer)):
            rows = [int(rows)]
        with holding(self):
            chosen: Any = rows if isinstance(rows, slice) else np.asarray(rows)
            return Gaussians(_copy(tuple(array[chosen] for array in self.arrays().values())))

    def __reduce__(self) -> Any:
        """Pickles the arrays, bit by bit, and the statistics; not the names of the patterns that save writes."""
        with holding(self):
            arrays = tuple(array.copy() for array in self.arrays().values())
        return _restored, (type(self), arrays, getattr(self, "stats", None))

    @classmethod
    def concatenate(cls, parts: Iterable[Gaussians]) -> Gaussians:
        """The Gaussians of several objects in one world, in their order, as a copy of their arrays.
        Raises ArgumentError without any."""
        several = list(parts)
        fit = bool(several) and all(isinstance(part, Gaussians) for part in several)
        expects(fit, "parts", "Gaussians, at least one", several)
        with holding(*several):
            return Gaussians(_copy(tuple(np.concatenate([p._array(name) for p in several]) for name in _WIDTHS)))

    def transformed(
        self, rotation: npt.ArrayLike = (0, 0, 0), translation: npt.ArrayLike = (0, 0, 0), scale: float = 1
    ) -> Gaussians:
        """A copy of the arrays, moved by x -> scale * rotation x + translation.

        Devices that should see the same move along: Pinhole.moved for scale 1. Light falls off with the square of the
        distance, so in a world that is larger by ``scale`` the projector's intensity is larger by scale^2.

        Args:
            rotation: [3,3], or OpenCV's rvec [3], axis times angle in radians.
            translation: [3] world units.
            scale: above 0.

        Raises:
            ArgumentError: not a rotation, three numbers and a scale above 0.
        """
        turn, way, s = rotation_of(rotation), np.asarray(translation, np.float64), float(scale)
        if not (np.isfinite(turn).all() and np.allclose(turn @ turn.T, np.eye(3), atol=1e-5) and np.linalg.det(turn) > 0):
            raise argument_error("not a rotation", "rotation")
        if way.shape != (3,):
            raise argument_error(f"shape {way.shape} is not (3,)", "translation")
        if not 0 < s < np.inf:
            raise argument_error(f"{s} is not above 0 and finite", "scale")
        with holding(self):
            arrays = self.arrays()
            centre = s * arrays["centre"].astype(np.float64) @ turn.T + way
            (a, *v), (w, *u) = quaternion_of(turn), arrays["rotation"].astype(np.float64).T
            first, then = np.array(v)[None, :], np.stack(u, 1)
            product = (a * w - then @ v)[:, None], a * then + w[:, None] * first + np.cross(first, then)
            moved = {"centre": centre, "scale": s * arrays["scale"], "rotation": np.concatenate(product, 1)}
            return Gaussians(_copy(tuple({**arrays, **moved}.values())))

    def copy(self) -> Gaussians:
        """A copy, checked as by from_arrays."""
        with holding(self):
            return Gaussians(_copy(tuple(self.arrays().values())))

    def check(self) -> None:
        """Raises an error that names array and row if values written to the arrays are invalid."""
        self.copy()

    def to_3dgs(self) -> dict[str, Floats]:
        """The parameters in the form of 3DGS and gsplat: ``means`` [count,3], ``scales`` [count,3] (natural
        logarithms), ``quats`` [count,4] (w x y z), ``opacities`` [count] (logits), ``sh0`` [count,1,3] (the object in
        ambient light, sRGB-encoded). A splat's ``colors`` are 0.5 + 0.2820948 * sh0."""
        share = np.clip(self.opacity.astype(np.float64), 1e-6, 1 - 1e-6)
        light = self.ambient.astype(np.float64)
        encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        out: dict[str, Array] = {
            "means": self.centre.copy(),
            "scales": np.log(np.maximum(self.scale, 1e-30)),
            "quats": self.rotation.copy(),
            "opacities": np.log(share / (1 - share)),
            "sh0": ((encoded - 0.5) / 0.28209479177387814)[:, None, :],
        }
        return {name: array.astype(np.float32) for name, array in out.items()}

    @classmethod
    def from_3dgs(
        cls,
        means: npt.ArrayLike,
        scales: npt.ArrayLike,
        quats: npt.ArrayLike,
        opacities: npt.ArrayLike,
        sh0: npt.ArrayLike,
        *,
        roughness: float = 0.5,
    ) -> Gaussians:
        """Plain splats in the form of to_3dgs: logarithms of the scales, logits of the opacities. Their colour becomes
        albedo (within [0,1]) and ambient colour, as when a PLY of 3DGS is read.
        Raises ArgumentError for a wrong shape or number."""
        encoded = np.clip(0.5 + 0.28209479177387814 * np.asarray(sh0, np.float64).reshape(-1, 3), 0, None)
        linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
        logits = np.asarray(opacities, np.float64).reshape(-1)
        return cls.from_arrays(
            means,
            np.exp(np.asarray(scales, np.float64)),
            quats,
            1 / (1 + np.exp(-np.clip(logits, -80, 80))),
            np.minimum(linear, 1),
            np.full(len(logits), roughness),
            linear,
        )

    def to_gsplat(self) -> dict[str, Floats]:
        """Keyword arguments of gsplat.rasterization, as arrays: ``means``, ``quats``, ``scales``, ``opacities``, and
        ``colors`` [count,3] (the object in ambient light, sRGB-encoded)."""
        plain = self.to_3dgs()
        return {
            "means": plain["means"],
            "quats": plain["quats"],
            "scales": self.scale.copy(),
            "opacities": self.opacity.copy(),
            "colors": (0.5 + np.float32(0.28209479177387814) * plain["sh0"][:, 0]).astype(np.float32),
        }

    def save(self, path: PathLike) -> None:
        """Writes a PLY that load reads, without Gaussians too faint to be visible (opacity below 1/255); it is an error
        if all of them are. Raises ArgumentError in that case, InputOutputError if the file cannot be written."""
        keep = Keep()
        with holding(self), Call() as call:
            call.check(lib.ffp_gaussians_save(call.context, self._pointer, keep.path(path), call.error))

    def to_bytes(self) -> bytes:
        """The contents of the file that save writes."""
        with holding(self), Call() as call:
            size = ffi.new("size_t *")
            made = lib.ffp_gaussians_bytes(call.context, self._pointer, size, call.error)
            return bytes(ffi.buffer(call.take(made, lib.ffp_free), size[0]))

    def export(
        self,
        path: PathLike,
        capture: Capture | PathLike | None = None,
        *,
        mesh: bool = False,
        resolution: int = 128,
        light: PathLike | None = None,
        fit: str = "cover",
        projector_view: str | None = None,
        camera_view: str | None = None,
        poses: PathLike | None = None,
        up: str = "z",
        form: str = "ours",
        force: bool = False,
        progress: ProgressOption = None,
        threads: int = 0,
    ) -> ExportStats:
        """Writes Gaussians for programs that do not simulate projectors, as ``ffprocams export`` does.

        Args:
            path: the extension selects the format: splats as .ply (the layout of 3DGS), .spz, .gltf or .glb
                (KHR_gaussian_splatting); a mesh as .glb, .gltf or .obj.
            capture: the capture that the Gaussians come from, or its path; needed for light and mesh.
            mesh: a closed surface with albedo and roughness instead of splats.
            resolution: cells along the mesh's longest side, 16 to 512.
            light: baked into the splats. None or "ambient": ambient light only; "white", the name of a pattern of the
                capture or an image file: also the projector showing it.
            fit: how an image file goes into the projector's frame: cover, contain, stretch or pixel.
            projector_view: view whose projector shines; None: the first.
            camera_view: view for whose camera highlights are baked in; None: no highlights.
            poses: file of camera and projector poses to take these views from; None: the capture's.
            up: of the Gaussians' world: z, y or -y; files use the axes of their format.
            form: in which the Gaussians are drawn, as in Renderer.
            force: let plain splats replace a PLY of relightable Gaussians.
            progress: see ffprocams.ProgressOption.
            threads: number of threads; 0: all processors.

        Raises:
            ArgumentError: an argument is wrong, or needs the capture.
            Error: a file cannot be read or written; its subclass says why.
        """
        given = None if capture is None else capture_of(capture)
        keep, options, stats = Keep(), ffi.new("FfpExport *", lib.ffp_export_defaults()), ffi.new("FfpExportStats *")
        options.file, options.mesh, options.resolution = keep.path(path), mesh, resolution
        options.light, options.framing = keep.path(light), one_of(FRAMINGS, fit, "fit")
        options.projector_view, options.camera_view = keep.text(projector_view), keep.text(camera_view)
        options.poses, options.up, options.form = keep.path(poses), one_of(_UPS, up, "up"), one_of(_FORMS, form, "form")
        options.force = force
        with holding(self, given), Call(progress, threads) as call:
            call.check(lib.ffp_export(call.context, self._pointer, _pointer_of(given), options, stats, call.error))
        out: ExportStats = record(ExportStats, stats)
        return out

    def page(
        self,
        path: PathLike,
        capture: Capture | PathLike,
        *,
        photographs: int = 512,
        poses: PathLike | None = None,
        form: str = "ours",
        samples: int = 0,
        progress: ProgressOption = None,
        threads: int = 0,
    ) -> PageStats:
        """Writes one HTML file that draws the Gaussians in a browser, as ``ffprocams view`` does.

        Args:
            path: of the HTML file.
            capture: the capture that the Gaussians come from, or its path.
            photographs: longest side, in pixels, of the photographs to include; 0: none.
            poses: file of additional camera and projector poses to jump to.
            form, samples: how Gaussians are drawn, as in Renderer; not "gs-procams".
            progress: see ffprocams.ProgressOption.
            threads: number of threads; 0: all processors.

        Raises:
            ArgumentError: an argument is wrong.
            Error: a file cannot be read or written; its subclass says why.
        """
        given = capture_of(capture)
        keep, options, stats = Keep(), ffi.new("FfpPage *", lib.ffp_page_defaults()), ffi.new("FfpPageStats *")
        options.file, options.poses, options.photographs = keep.path(path), keep.path(poses), photographs
        options.drawing = drawing_of(form, samples)
        with holding(self, given), Call(progress, threads) as call:
            call.check(lib.ffp_write_page(call.context, self._pointer, given._pointer, options, stats, call.error))
        out: PageStats = record(PageStats, stats)
        return out

    def render(
        self,
        folder: PathLike,
        capture: Capture | PathLike | None = None,
        *,
        views: str | Sequence[str] = (),
        patterns: PathLike | Sequence[PathLike] = (),
        fit: str = "cover",
        width: int = 0,
        height: int = 0,
        intensity: npt.ArrayLike = 0,
        poses: PathLike | None = None,
        orbit: str | None = None,
        frames: int = 0,
        video: PathLike | None = None,
        rate: int = 15,
        maps: bool = False,
        form: str = "ours",
        samples: int = 0,
        progress: ProgressOption = None,
        threads: int = 0,
    ) -> int:
        """Writes pictures of views under patterns, or a film of an orbit, as ``ffprocams render`` does. Returns the number
        of pictures, G-buffers included. For arrays see Renderer.

        Args:
            folder: for `VIEW_PATTERN.png`, or `frame_NUMBER.png` with an orbit or a video; created if necessary.
            capture: the capture that the Gaussians come from, or its path; None: ``poses`` names a file.
            views: ids; none: all.
            patterns: names of the capture's patterns, image files or folders of image files; none: white.
            fit: how image files go into the projector's frame: cover, contain, stretch or pixel.
            width, height: of the pictures, pixels; 0: the camera's.
            intensity: [3] or one number, the projector's radiant intensity at pattern value 1; 0: the capture's.
            poses: file of camera and projector poses; None: the capture's.
            orbit: one full turn of the "camera", the "projector" or the "object", from the first of ``views``.
            frames: number of pictures of the orbit.
            video: file for a film of all pictures: .png, .apng, .gif, .mp4, .webm or .mkv (by ffmpeg).
            rate: frames per second of the film, 1 to 1000.
            maps: also write the G-buffers.
            form, samples: how Gaussians are drawn, as in Renderer.
            progress: see ffprocams.ProgressOption.
            threads: number of threads; 0: all processors.

        Raises:
            ArgumentError: an argument is wrong, or names a view or pattern that the capture lacks.
            Error: a file cannot be read or written; its subclass says why.
        """
        given = None if capture is None else capture_of(capture)
        keep, options = Keep(), ffi.new("FfpPictures *", lib.ffp_pictures_defaults())
        ids, shown = [keep.text(v) for v in some(views)], [keep.path(p) for p in some(patterns)]
        options.views, options.n_views = keep.texts(ids), len(ids)
        options.patterns, options.n_patterns = keep.texts(shown), len(shown)
        options.folder, options.poses, options.video = keep.path(folder), keep.path(poses), keep.path(video)
        options.framing, options.width, options.height = one_of(FRAMINGS, fit, "fit"), width, height
        options.intensity, options.frames, options.rate, options.maps = three(intensity, "intensity"), frames, rate, maps
        if orbit is not None:
            options.orbit = one_of(_ORBITS, orbit, "orbit")
        options.drawing = drawing_of(form, samples)
        with holding(self, given), Call(progress, threads) as call:
            written = lib.ffp_render_pictures(call.context, self._pointer, _pointer_of(given), options, call.error)
            return int(call.check(written))

    def __len__(self) -> int:
        return int(lib.ffp_gaussians_count(self._pointer))

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {len(self)}>"


def _copy(given: tuple[npt.ArrayLike | None, ...]) -> Any:
    """A pointer to new Gaussians with a copy of the numbers, in the order of _WIDTHS; None: the library's default."""
    arrays, keep = ffi.new("FfpGaussianArrays *"), Keep()
    count = len(np.atleast_1d(np.asarray(given[0])))
    for (name, width), numbers in zip(_WIDTHS.items(), given):
        if numbers is None and name == "scattered":
            continue
        array = keep(np.ascontiguousarray(numbers, np.float32))
        if array.shape != ((count,) if width == 1 else (count, width)):
            wanted = f"[{count}]" if width == 1 else f"[{count},{width}]"
            raise argument_error(f"shape {array.shape} is not {wanted}", name)
        setattr(arrays, name, ffi.cast("float *", array.__array_interface__["data"][0]))
    arrays.count = count
    with Call() as call:
        return call.take(
            lib.ffp_gaussians_from_arrays(call.context, arrays, call.error), lib.ffp_gaussians_close
        )


def _pointer_of(given: Handle | None) -> Any:
    return ffi.NULL if given is None else given._pointer


def _restored(kind: type[Any], arrays: tuple[Floats, ...], stats: Any) -> Any:
    """The Gaussians that __reduce__ took apart."""
    out = kind(_copy(arrays))
    if stats is not None:
        out.stats = stats
    return out


def gaussians_of(given: Gaussians | PathLike) -> Gaussians:
    """Gaussians, or those of a file."""
    return given if isinstance(given, Gaussians) else Gaussians.load(given)


@checked
class Model(Handle):
    """Weights of the network."""

    @classmethod
    def open(cls, path: PathLike | None = None) -> Model:
        """Reads safetensors. None: the shipped weights, or small.safetensors in the folder named by the environment
        variable FFPROCAMS_MODELS. Raises MissingFileError or FileFormatError for a file that is missing or damaged."""
        keep = Keep()
        with Call() as call:
            return cls(
                call.take(lib.ffp_model_open(call.context, keep.path(path), ffi.NULL, call.error), lib.ffp_model_close)
            )

    @classmethod
    def from_bytes(cls, contents: bytes) -> Model:
        """As open, from a file's contents. Raises FileFormatError for damaged contents."""
        keep = Keep()
        with Call() as call:
            made = lib.ffp_model_open(call.context, ffi.NULL, keep.contents(contents), call.error)
            return cls(call.take(made, lib.ffp_model_close))

    def to_bytes(self, *, exact: bool = False) -> bytes:
        """The contents of the file that save writes. Raises ArgumentError if ``exact`` is not True or False."""
        with holding(self), Call() as call:
            size = ffi.new("size_t *")
            made = lib.ffp_model_bytes(call.context, self._pointer, exact, size, call.error)
            return bytes(ffi.buffer(call.take(made, lib.ffp_free), size[0]))

    def weights(self) -> dict[str, Floats]:
        """The weights by name, in the file's order: matrices [rows,columns] and vectors. They are views of the
        library's memory and may be written to; new values are not checked."""
        out = {}
        for i in range(lib.ffp_model_weights_count(self._pointer)):
            w = lib.ffp_model_weights(self._pointer, i)
            shape = (w.rows, w.columns) if w.columns else (w.rows,)
            out[ffi.string(w.name).decode()] = floats_at(w.values, shape, self, writable=True)
        return out

    def save(self, path: PathLike, *, exact: bool = False) -> None:
        """Writes safetensors that open reads. exact: matrices in float32, not in bfloat16.
        Raises InputOutputError if it cannot be written."""
        keep = Keep()
        with holding(self), Call() as call:
            call.check(lib.ffp_model_save(call.context, self._pointer, keep.path(path), exact, call.error))


_FORMS = {"ours": lib.FFP_FORM_OURS, "paper": lib.FFP_FORM_PAPER, "gs-procams": lib.FFP_FORM_GS_PROCAMS}


def drawing_of(form: str, samples: int) -> dict[str, int]:
    """An FfpDrawing."""
    expects(0 <= samples <= 4, "samples", "0 to 4", samples)
    return {"form": one_of(_FORMS, form, "form"), "samples": samples}
