"""Conversion of pictures between NumPy and the library, without copies if the memory layout allows."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._arguments import checked
from ._call import Keep
from ._library import ffi, lib
from .errors import argument_error

Array = npt.NDArray[Any]
Floats = npt.NDArray[np.float32]

_TYPES = {
    np.dtype(np.uint8): lib.FFP_PIXELS_U8,
    np.dtype(np.uint16): lib.FFP_PIXELS_U16,
    np.dtype(np.float32): lib.FFP_PIXELS_F32,
}


class Owned:
    """Memory that belongs to the library: a NumPy array made from it keeps its owner alive."""

    def __init__(self, pointer: Any, shape: tuple[int, ...], owner: object, writable: bool) -> None:
        self.owner = owner
        address = int(ffi.cast("uintptr_t", pointer))
        self.__array_interface__ = {
            "shape": shape,
            "typestr": "<f4",
            "data": (address, not writable),
            "version": 3,
        }


def floats_at(pointer: Any, shape: tuple[int, ...], owner: object, writable: bool = False) -> Floats:
    """An array of floats in the library's memory, not copied."""
    if pointer == ffi.NULL or 0 in shape:
        return np.zeros(shape, np.float32)
    return np.asarray(Owned(pointer, shape, owner, writable))


def array_of(picture: Any, owner: object) -> Floats | None:
    """An FfpPicture of floats as an array [height,width,channels] ([height,width] of one channel), read only."""
    if picture.data == ffi.NULL:
        return None
    size = (picture.height, picture.width)
    return floats_at(picture.data, size if picture.channels == 1 else (*size, picture.channels), owner)


def picture_of(picture: Array | None, keep: Keep, name: str) -> Any:
    """An array as an FfpPicture. It is copied only if its pixels are not contiguous or its type is not supported: bool
    becomes uint8, other floats float32."""
    out = ffi.new("FfpPicture *")
    if picture is None:
        return keep(out)
    array = np.asarray(picture)
    if array.dtype == np.bool_:
        array = array.astype(np.uint8) * np.uint8(255)
    elif array.dtype.kind == "f" and array.dtype != np.float32:
        array = array.astype(np.float32)
    if array.dtype not in _TYPES:
        raise argument_error(f"pictures must be uint8, uint16 or float32, not {array.dtype}", name)
    if array.ndim == 2:
        array = array[:, :, None]
    if array.ndim != 3 or array.shape[2] not in (1, 3, 4) or 0 in array.shape:
        raise argument_error(
            f"shape {np.shape(picture)} is not [height,width] or [height,width,1, 3 or 4]", name
        )
    pixel = array.shape[2] * array.itemsize
    together = array.shape[2] == 1 or array.strides[2] == array.itemsize
    sound = together and array.strides[1] == pixel and array.strides[0] >= array.shape[1] * pixel
    if not (sound and array.flags.aligned and array.dtype.isnative):
        array = np.ascontiguousarray(array, array.dtype.newbyteorder("="))
    keep(array)
    out.data = ffi.cast("void *", array.__array_interface__["data"][0])
    out.height, out.width, out.channels = array.shape
    out.type = _TYPES[array.dtype]
    out.row_bytes = array.strides[0]
    return keep(out)


@checked
def encode(linear: npt.ArrayLike) -> Floats:
    """Linear light in [0,1] as sRGB-encoded values in [0,1] (IEC 61966-2-1); values outside are clipped.
    Raises ArgumentError for anything but numbers."""
    x = np.clip(np.asarray(linear, np.float32), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** np.float32(1 / 2.4) - 0.055).astype(np.float32)


@checked
def decode(encoded: npt.ArrayLike) -> Floats:
    """sRGB-encoded values in [0,1] as linear light in [0,1]. Raises ArgumentError for anything but numbers."""
    x = np.clip(np.asarray(encoded, np.float32), 0, 1)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** np.float32(2.4)).astype(np.float32)
