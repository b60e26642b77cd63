"""Rendering of Gaussians into arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import devices
from ._arguments import checked, expects, one_of
from ._call import Call, Handle, Keep, PathLike, holding
from ._library import ffi, lib
from ._pixels import Array, Floats, picture_of
from .capture import three
from .devices import Pinhole
from .errors import argument_error
from .gaussians import Gaussians, drawing_of, gaussians_of

_MAPS = {
    "opacity": lib.FFP_MAP_OPACITY,
    "depth": lib.FFP_MAP_DEPTH,
    "normal": lib.FFP_MAP_NORMAL,
    "albedo": lib.FFP_MAP_ALBEDO,
    "roughness": lib.FFP_MAP_ROUGHNESS,
    "ambient": lib.FFP_MAP_AMBIENT,
    "distortion": lib.FFP_MAP_DISTORTION,
}


def _dtype(dtype: npt.DTypeLike | None, linear: bool) -> npt.DTypeLike:
    if dtype is None:
        return np.float32 if linear else np.uint8
    return dtype


@checked
class Renderer(Handle):
    """One view of Gaussians, rasterised once (aim) and shaded under any number of patterns (shade)."""

    def __init__(self, *, form: str = "ours", samples: int = 0, threads: int = 0) -> None:
        """
        Args:
            form: "ours" (firm splats, footprint lookup, shadows), "paper" (blur, bilinear lookup, no shadows) or
                "gs-procams" (the paper's form, in light without cosine and falloff).
            samples: per side of a pixel, 1 to 4; 0: 2, or 1 in the paper's form.
            threads: number of threads; 0: all processors.
        """
        self._call = Call(threads=threads)
        self._size: tuple[int, int] | None = None
        drawing = drawing_of(form, samples)
        with self._call as call:
            made = lib.ffp_renderer_new(call.context, drawing, call.error)
            super().__init__(call.take(made, lib.ffp_renderer_close))

    def aim(self, gaussians: Gaussians | PathLike, camera: Pinhole, projector: Pinhole) -> Renderer:
        """Rasterises for a camera and maps the visible surface to a projector. Each side may have 1 to 16384 pixels.
        The Gaussians are not accessed afterwards. Returns itself. Raises ArgumentError for another size or type."""
        gaussians = gaussians_of(gaussians)
        with holding(self, gaussians), self._call as call:
            self._size = None
            call.check(
                lib.ffp_renderer_aim(
                    call.context,
                    self._pointer,
                    gaussians._pointer,
                    devices.to_c(camera),
                    devices.to_c(projector),
                    call.error,
                )
            )
            self._size = (camera.height, camera.width)
        return self

    def _aimed(self) -> tuple[int, int]:
        if self._size is None:
            raise argument_error("not aimed yet", "renderer")
        return self._size

    def shade(
        self,
        pattern: Array | None,
        intensity: npt.ArrayLike,
        *,
        out: Array | None = None,
        dtype: npt.DTypeLike | None = None,
        linear: bool = False,
    ) -> Array:
        """The camera's picture of the object over black under one pattern.

        Args:
            pattern: [height,width,3] of the projector's size: uint8 or uint16 sRGB-encoded, float32 linear; None: a
                dark projector.
            intensity: [3] or one number, the projector's radiant intensity at pattern value 1.
            out: [height,width,3] of the camera's size, uint8 or float32, to write the result into; the pixels of a row
                must be contiguous, rows need not be.
            dtype: of the result if ``out`` is None: uint8 (default) or float32.
            linear: linear radiance, premultiplied by opacity and not clipped, as float32.

        Returns:
            [height,width,3] sRGB-encoded: uint8, or float32 in [0,1]; or float32 of linear radiance.

        Raises:
            ArgumentError: an argument is wrong, or nothing has been aimed at.
        """
        with holding(self):
            return self._shade(pattern, three(intensity, "intensity"), self._out(out, dtype, linear), linear)

    def shade_many(
        self,
        patterns: Sequence[Array | None] | Array,
        intensity: npt.ArrayLike,
        *,
        dtype: npt.DTypeLike | None = None,
        linear: bool = False,
    ) -> Array:
        """The pictures under n patterns, [n,height,width,3]; arguments as for shade. Raises what that raises."""
        light = three(intensity, "intensity")
        with holding(self):
            out = np.empty((len(patterns), *self._aimed(), 3), _dtype(dtype, linear))
            for picture, pattern in zip(out, patterns):
                self._shade(pattern, light, self._out(picture, dtype, linear), linear)
        return out

    def _out(self, out: Array | None, dtype: npt.DTypeLike | None, linear: bool) -> Array:
        shape = (*self._aimed(), 3)
        if out is None:
            out = np.empty(shape, _dtype(dtype, linear))
        expects(isinstance(out, np.ndarray), "out", "an array", out)
        if linear and out.dtype != np.float32:
            raise argument_error(f"linear radiance is float32, not {out.dtype}", "out")
        if out.dtype not in (np.uint8, np.float32):
            raise argument_error(f"pictures must be uint8 or float32, not {out.dtype}", "out")
        apart = 3 * shape[1] * out.itemsize
        sound = (
            out.strides[1:] == (3 * out.itemsize, out.itemsize) and out.strides[0] >= apart
            if out.ndim == 3
            else False
        )
        if out.shape != shape or not sound or not out.flags.writeable:
            raise argument_error(f"expected a writable array {shape} with contiguous rows", "out")
        return out

    def _shade(self, pattern: Array | None, intensity: list[float], out: Array, linear: bool) -> Array:
        keep = Keep()
        kind = lib.FFP_PIXELS_RADIANCE if linear else lib.FFP_PIXELS_U8 if out.dtype == np.uint8 else lib.FFP_PIXELS_F32
        picture = picture_of(pattern, keep, "pattern")
        memory = ffi.cast("void *", out.__array_interface__["data"][0])
        size = (out.shape[0] - 1) * out.strides[0] + out.shape[1] * 3 * out.itemsize
        with self._call as call:
            call.check(
                lib.ffp_renderer_shade(
                    call.context,
                    self._pointer,
                    picture,
                    intensity,
                    memory,
                    size,
                    kind,
                    out.strides[0],
                    call.error,
                )
            )
        return out

    def map(self, name: str) -> Floats:
        """One G-buffer, averaged over each pixel: "opacity" [height,width] in [0,1]; "depth" [height,width] camera z in
        world units, 0 where the opacity is below one half; "normal" [height,width,3] world, unit length, 0 off the
        object; "albedo" [height,width,3] linear; "roughness" [height,width]; "ambient" [height,width,3] linear
        radiance, premultiplied by opacity; "distortion" [height,width], how far apart the splats at a pixel are along its
        ray: sum_ij W_i W_j |z_i - z_j| of their weights and depths, world units (FF-ProCams, Eq. 22).
        Raises ArgumentError for another name, or if nothing has been aimed at."""
        which = one_of(_MAPS, name, "name")
        with holding(self):
            channels = lib.ffp_map_channels(which)
            out = np.empty((*self._aimed(), channels) if channels > 1 else self._aimed(), np.float32)
            memory: Any = ffi.cast("float *", out.__array_interface__["data"][0])
            with self._call as call:
                call.check(
                    lib.ffp_renderer_map(
                        call.context, self._pointer, which, memory, out.size, call.error
                    )
                )
        return out

    def maps(self) -> dict[str, Floats]:
        """All G-buffers by name."""
        return {name: self.map(name) for name in _MAPS}
