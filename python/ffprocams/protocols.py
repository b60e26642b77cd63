"""The paper's protocols for any method given as a function, with the same figures as evaluate.

A method takes Inputs, which contain only what it may use, and returns a prediction function. From a camera, a projector
and the projected pattern (linear, [height,width,3]), this predicts the camera's picture of the object over black
([height,width,3], uint8 or floats in [0,1], sRGB-encoded).
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import numpy as np
import numpy.typing as npt

from ._arguments import checked, expects
from ._call import Call, Keep, PathLike
from ._library import ffi, lib
from ._pixels import Array, Floats, encode, picture_of
from .capture import Capture, View
from .devices import Doubles, Pinhole
from .errors import argument_error

Predictor = Callable[[Pinhole, Pinhole, Floats], Array]


@dataclass
class Inputs:
    """The part of a capture that a method may use: its views under black, white and one structured-light pattern."""

    name: str
    view_ids: tuple[str, ...]
    cameras: list[Pinhole]
    projectors: list[Pinhole]
    black: list[Floats]  #: one per view, [height,width,3] linear, over black
    white: list[Floats]
    structured: list[Floats]
    coverage: list[Floats]  #: [height,width] the object's share of each pixel
    pattern_name: str
    pattern: Floats  #: [height,width,3] linear, of the projector's size
    intensity: Doubles  #: [3] the projector's radiant intensity at pattern value 1, W/sr
    centre: Doubles  #: [3] centre of a sphere around the object, world units
    radius: float

    def capture(self) -> Capture:
        """These inputs as a Capture."""
        names = ("black", "white", self.pattern_name)
        views = [
            View(i, camera, projector, dict(zip(names, photographs)), mask, masked=True)
            for i, camera, projector, mask, *photographs in zip(
                self.view_ids,
                self.cameras,
                self.projectors,
                self.coverage,
                self.black,
                self.white,
                self.structured,
            )
        ]
        patterns = {"black": None, "white": None, self.pattern_name: self.pattern}
        sphere, light = {"centre": self.centre, "radius": self.radius}, self.intensity
        return Capture.from_arrays(views, patterns, intensity=light, name=self.name, **sphere)  # type: ignore[arg-type]


@dataclass
class Row:
    """The figures of a method on a capture under a protocol: means over the images."""

    method: str
    capture: str
    protocol: str  #: "rendering", "novel_pattern" or "novel_pose"
    psnr: float  #: dB
    psnr_foreground: float  #: over pixels that the object covers
    ssim: float
    lpips: float  #: NaN without weights
    images: int
    reconstruct_s: float  #: seconds
    render_s: float


def _pair(a: npt.ArrayLike, b: npt.ArrayLike) -> tuple[Array, Array]:
    x, y = np.asarray(a, np.float64), np.asarray(b, np.float64)
    expects(x.shape == y.shape, "b", f"shape {x.shape}", y.shape)
    return x, y


@checked
def psnr(a: npt.ArrayLike, b: npt.ArrayLike, mask: Array | None = None) -> float:
    """Peak signal-to-noise ratio in dB of pictures in [0,1], over pixels where the mask [height,width] is above 0;
    100 for identical pictures, NaN if there are no pixels. Raises ArgumentError if their shapes differ."""
    x, y = _pair(a, b)
    squares = (x - y) ** 2
    if mask is not None:
        expects(np.shape(mask) == x.shape[:2], "mask", f"shape {x.shape[:2]}", np.shape(mask))
        squares = squares[np.asarray(mask) > 0]
    if squares.size == 0:
        return float("nan")
    mean = float(squares.mean())
    return 100.0 if mean <= 1e-10 else -10 * float(np.log10(mean))


@checked
def ssim(a: npt.ArrayLike, b: npt.ArrayLike) -> float:
    """Structural similarity (Wang et al. 2004) of pictures [height,width,channels] in [0,1]: 11x11 Gaussian window,
    sigma 1.5, zero padding at the borders. Raises ArgumentError if their shapes differ."""
    taps = np.exp(-0.5 * ((np.arange(11) - 5) / 1.5) ** 2)
    taps /= taps.sum()

    def blur(x: Array) -> Array:
        for axis in (0, 1):
            wide = np.pad(x, [(5, 5) if i == axis else (0, 0) for i in range(x.ndim)])
            x = sum(t * np.take(wide, range(i, i + x.shape[axis]), axis) for i, t in enumerate(taps))
        return x

    x, y = _pair(a, b)
    mean_x, mean_y = blur(x), blur(y)
    var_x, var_y, both = blur(x * x) - mean_x**2, blur(y * y) - mean_y**2, blur(x * y) - mean_x * mean_y
    c1, c2 = 0.01**2, 0.03**2
    index = (
        (2 * mean_x * mean_y + c1) * (2 * both + c2) / ((mean_x**2 + mean_y**2 + c1) * (var_x + var_y + c2))
    )
    return float(index.mean())


@checked
def lpips(a: Sequence[Array], b: Sequence[Array], weights: PathLike) -> Doubles:
    """[n] perceptual distances (Zhang et al. 2018, version 0.1) of n pairs of pictures [height,width,3] over black:
    uint8 and uint16 sRGB-encoded, floats linear. ``weights``: safetensors as ``python -m ffprocams.perceptual`` writes.
    Raises ArgumentError for other pictures, MissingFileError or FileFormatError for the file."""
    if len(a) != len(b):
        raise argument_error(f"{len(b)} pictures for {len(a)}", "b")
    keep, distances = Keep(), np.full(len(a), np.nan)
    one, other = (
        keep(ffi.new("FfpPicture[]", [picture_of(p, keep, f"{name}[{i}]")[0] for i, p in enumerate(pictures)]))
        for name, pictures in (("a", a), ("b", b))
    )
    with Call() as call:
        out = ffi.cast("double *", distances.ctypes.data)
        call.check(lib.ffp_lpips(call.context, keep.path(weights), one, other, len(a), out, call.error))
    return distances


def _weights(perceptual: PathLike | None) -> PathLike | None:
    """As evaluate finds them."""
    folder = os.environ.get("FFPROCAMS_PERCEPTUAL")
    return perceptual if perceptual or not folder else Path(folder) / "lpips_alex.safetensors"


@checked
def shown(capture: Capture, pattern: str) -> Floats:
    """[height,width,3] linear: the projected picture, also for black and white.
    Raises ArgumentError if there is no such pattern."""
    picture = capture.pattern(pattern)
    if picture is not None:
        return picture
    projector = capture.projector(0)
    return np.full((projector.height, projector.width, 3), float(pattern == capture.white), np.float32)


@checked
def structured_pattern(capture: Capture) -> str:
    """A reconstruction's default pattern: the first that every view has, not black, white or held out.
    Raises ArgumentError if there is none."""
    for name in capture.pattern_names:
        if name in (capture.black, capture.white, *capture.held_out):
            continue
        if all(capture.photograph(v, name) is not None for v in capture.view_ids):
            return name
    raise argument_error("no structured-light pattern that every view has", "capture")


@checked
def inputs_of(capture: Capture, pattern: str | None = None, name: str = "capture") -> Inputs:
    """The part of a capture that a method may use. ``pattern``: of the structured light; None: structured_pattern.
    Raises ArgumentError if a view has no photograph under it, black or white."""
    pattern = structured_pattern(capture) if pattern is None else pattern

    def under(which: str) -> list[Floats]:
        out = [capture.photograph(v, which) for v in capture.view_ids]
        if any(p is None for p in out):
            raise argument_error(f"not every view has a photograph under '{which}'", name)
        return [p for p in out if p is not None]

    return Inputs(
        name, capture.view_ids, [capture.camera(v) for v in capture.view_ids],
        [capture.projector(v) for v in capture.view_ids], under(capture.black), under(capture.white), under(pattern),
        [capture.coverage(v) for v in capture.view_ids], pattern, shown(capture, pattern), capture.intensity,
        capture.centre, capture.radius,
    )  # fmt: skip


def _score(
    method: str,
    name: str,
    protocol: str,
    truth: Capture,
    patterns: Iterable[str],
    predict: Predictor,
    weights: PathLike | None,
) -> Row:
    figures, distances, seconds = [], [np.empty(0)], 0.0
    for pattern in patterns:
        light, pictures, photographs = shown(truth, pattern), [], []
        for view in truth.view_ids:
            photograph = truth.photograph(view, pattern)
            if photograph is None:
                continue
            camera, projector = truth.camera(view), truth.projector(view)
            begin = time.perf_counter()
            picture = np.asarray(predict(camera, projector, light))
            seconds += time.perf_counter() - begin
            if picture.shape != photograph.shape:
                raise argument_error(
                    f"a prediction has shape {picture.shape}, not {photograph.shape}", f"{method}: {view}"
                )
            if picture.dtype != np.uint8:
                if not np.abs(picture).max() < 2:  # NaN, or 0 to 255
                    raise argument_error("a prediction is not uint8 or floats in [0,1]", f"{method}: {view}")
                picture = np.rint(np.clip(picture, 0, 1) * 255).astype(np.uint8)
            pictures.append(picture)
            photographs.append(photograph)
            predicted, true = picture.astype(np.float64) / 255, encode(photograph)
            figures.append(
                (psnr(predicted, true), psnr(predicted, true, truth.coverage(view)), ssim(predicted, true))
            )
        if weights is not None:
            distances.append(lpips(pictures, photographs, weights))
    if not figures:
        nan = float("nan")
        return Row(method, name, protocol, nan, nan, nan, nan, 0, nan, nan)
    columns = np.array(figures)
    foreground = columns[np.isfinite(columns[:, 1]), 1]
    mean = float(foreground.mean()) if foreground.size else float("nan")
    perceived = float(np.concatenate(distances).mean()) if weights is not None else float("nan")
    return Row(
        method,
        name,
        protocol,
        columns[:, 0].mean(),
        mean,
        columns[:, 2].mean(),
        perceived,
        len(figures),
        0.0,
        seconds,
    )


@checked
def run(
    captures: PathLike | Sequence[PathLike],
    methods: Mapping[str, Callable[[Inputs], Predictor]],
    *,
    targets: str | None = None,
    pattern: str | None = None,
    perceptual: PathLike | None = None,
) -> list[Row]:
    """Runs methods on captures under the three protocols; protocols without images are left out.

    Args:
        captures: folders, or JSON files in them.
        methods: by name.
        targets: name of the file in each capture folder with the poses and pictures for "novel_pose"; None: no such
            protocol. Its views must have pictures under black and white.
        pattern: name of the structured-light pattern; None: the first that every view has.
        perceptual: safetensors with LPIPS weights; None: lpips_alex.safetensors in the folder that the environment
            variable FFPROCAMS_PERCEPTUAL names; without either there is no LPIPS.

    Raises:
        ArgumentError: an argument is wrong, or a method predicts anything but a picture.
        Error: a file cannot be read; its subclass says why.
    """
    rows: list[Row] = []
    weights = _weights(perceptual)
    for path in [captures] if isinstance(captures, (str, os.PathLike)) else captures:
        capture, folder = Capture.open(path), Path(os.fspath(path))
        folder = folder if folder.is_dir() else folder.parent
        name = folder.name
        given = inputs_of(capture, pattern, name)
        seen = [p for p in capture.pattern_names if p not in capture.held_out or p == given.pattern_name]
        held_out = [p for p in capture.pattern_names if p not in seen]
        poses = Capture.open(folder / targets) if targets else None
        for method, reconstruct in methods.items():
            begin = time.perf_counter()
            predict = reconstruct(given)
            took = time.perf_counter() - begin
            of_method = [
                _score(method, name, "rendering", capture, seen, predict, weights),
                _score(method, name, "novel_pattern", capture, held_out, predict, weights),
            ]
            if poses:
                of_method.append(_score(method, name, "novel_pose", poses, poses.pattern_names, predict, weights))
            for row in of_method:
                row.reconstruct_s = took
            rows += [row for row in of_method if row.images]
    return rows


@checked
def table(rows: Sequence[Row]) -> str:
    """The rows as a readable table; with a column of LPIPS where there are weights for it.
    Raises ArgumentError for anything but rows."""
    perceived = any(np.isfinite(r.lpips) for r in rows)
    lines = [
        f"{'capture':16} {'protocol':14} {'method':20} {'PSNR':>6} {'object':>6} {'SSIM':>7}"
        f"{'   LPIPS' if perceived else ''} {'images':>6} {'s':>8}"
    ]
    lines += [
        f"{r.capture:16} {r.protocol:14} {r.method:20} {r.psnr:6.2f} {r.psnr_foreground:6.2f} {r.ssim:7.4f}"
        f"{f' {r.lpips:7.4f}' if perceived else ''} {r.images:6d} {r.reconstruct_s:8.2f}"
        for r in rows
    ]
    return "\n".join(lines)
