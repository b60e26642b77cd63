"""LPIPS weights for ffprocams, from the PyTorch files that a researcher has.

    python -m ffprocams.perceptual -o FOLDER [FILE.pth ..]

Writes lpips_alex.safetensors, lpips_squeeze.safetensors and vgg16_relu2_2.safetensors, as far as there are weights for
them. FILES may be in any order and have any names: torchvision's ImageNet weights of AlexNet, SqueezeNet 1.1 and VGG16
(alexnet-owt-7be5be79.pth and so on) and the linear heads of LPIPS 0.1 (alex.pth and squeeze.pth in the folder
lpips/weights/v0.1 of the package "lpips"). Without FILES they are looked for where torchvision and lpips keep them.
The weights are other people's work, and no part of this project. Only torch is needed, to open the files.
"""

from __future__ import annotations

import argparse
import array
import importlib.util
import json
import os
import struct
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ._arguments import checked
from ._call import PathLike
from .errors import ErrorCode, FileFormatError

_Shape = tuple[int, ...]
_Tensor = tuple[str, _Shape, bytes]


class _Failure(FileFormatError):
    """A fault, and the file that has it, or its part: "PATH: TENSOR"."""

    def __init__(self, text: str, where: object = "") -> None:
        super().__init__(f"{text} ({where})" if where else text, ErrorCode.FILE, str(where))


def _conv(name: str, out_channels: int, in_channels: int, kernel: int) -> list[tuple[str, _Shape]]:
    """The two tensors of one convolution."""
    return [
        (name + ".weight", (out_channels, in_channels, kernel, kernel)),
        (name + ".bias", (out_channels,)),
    ]


def _fire(index: int, inputs: int, squeeze: int, expand: int) -> list[tuple[str, _Shape]]:
    """One SqueezeNet module: 1x1 down, then 1x1 and 3x3 up."""
    name = f"features.{index}."
    return (
        _conv(name + "squeeze", squeeze, inputs, 1)
        + _conv(name + "expand1x1", expand, squeeze, 1)
        + _conv(name + "expand3x3", expand, squeeze, 3)
    )


# For each network the file to write, what is taken of its backbone, in file order, how many convolutions that has in
# all (VGG13, 16 and 19 begin alike), the channels of its heads, and the file's metadata.
NETWORKS: dict[str, dict[str, Any]] = {
    "alex": {
        "file": "lpips_alex.safetensors",
        "convolutions": 5,
        "backbone": _conv("features.0", 64, 3, 11)
        + _conv("features.3", 192, 64, 5)
        + _conv("features.6", 384, 192, 3)
        + _conv("features.8", 256, 384, 3)
        + _conv("features.10", 256, 256, 3),
        "heads": (64, 192, 384, 256, 256),
        "metadata": {
            "network": "alex",
            "version": "0.1",
            "backbone": "torchvision ImageNet weights",
            "input": "RGB in [-1,1]",
        },
    },
    "squeeze": {
        "file": "lpips_squeeze.safetensors",
        "convolutions": 25,
        "backbone": _conv("features.0", 64, 3, 3)
        + _fire(3, 64, 16, 64)
        + _fire(4, 128, 16, 64)
        + _fire(6, 128, 32, 128)
        + _fire(7, 256, 32, 128)
        + _fire(9, 256, 48, 192)
        + _fire(10, 384, 48, 192)
        + _fire(11, 384, 64, 256)
        + _fire(12, 512, 64, 256),
        "heads": (64, 128, 256, 384, 384, 512, 512),
        "metadata": {
            "network": "squeeze",
            "version": "0.1",
            "backbone": "torchvision ImageNet weights",
            "input": "RGB in [-1,1]",
        },
    },
    "vgg16": {
        "file": "vgg16_relu2_2.safetensors",
        "convolutions": 13,
        "backbone": _conv("features.0", 64, 3, 3)
        + _conv("features.2", 64, 64, 3)
        + _conv("features.5", 128, 64, 3)
        + _conv("features.7", 128, 128, 3),
        "heads": (),
        "metadata": {
            "network": "vgg16 up to relu2_2",
            "backbone": "torchvision ImageNet weights",
            "input": "RGB, ImageNet mean/std",
        },
    },
}


def _load(path: Path) -> dict[str, Any]:
    """A .pth file's tensors by name. weights_only: a file from the net must not run code here."""
    try:
        import torch
    except ImportError:
        raise _Failure("this needs PyTorch to open the files: pip install torch") from None
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
    except OSError as error:
        raise _Failure(f"{error.strerror}", path) from None
    except Exception:  # torch names no common type for what a damaged file raises
        raise _Failure("not a file of PyTorch weights", path) from None
    if not isinstance(state, dict):
        raise _Failure("not a table of tensors", path)
    return state


def _has(state: dict[str, Any], name: str, shape: _Shape) -> bool:
    return tuple(getattr(state.get(name), "shape", ())) == shape


def _head(index: int) -> str:
    return f"lin{index}.model.1.weight"


def _recognise(state: dict[str, Any]) -> tuple[str, str] | None:
    """The network, and "backbone" or "heads"."""
    layers = sum(key.startswith("features.") and key.endswith(".weight") for key in map(str, state))
    for name, network in NETWORKS.items():
        if layers == network["convolutions"] and all(_has(state, *t) for t in network["backbone"][:3]):
            return name, "backbone"
        heads = [(_head(i), (1, channels, 1, 1)) for i, channels in enumerate(network["heads"])]
        if heads and all(_has(state, *h) for h in heads) and _head(len(heads)) not in state:
            return name, "heads"
    return None


def _take(state: dict[str, Any], path: Path, stored: str, name: str, shape: _Shape) -> _Tensor:
    """One tensor, as little-endian fp32."""
    if stored not in state:
        raise _Failure("no such tensor", f"{path}: {stored}")
    if not _has(state, stored, shape):
        raise _Failure(f"shape {tuple(state[stored].shape)}, not {shape}", f"{path}: {stored}")
    values = array.array("f", state[stored].detach().float().flatten().tolist())
    if sys.byteorder == "big":
        values.byteswap()
    return name, shape, values.tobytes()


def _write(path: Path, tensors: Sequence[_Tensor], metadata: dict[str, str]) -> None:
    """Safetensors: length of the header, header (JSON, padded to a multiple of 8), data; renamed when whole."""
    header: dict[str, Any] = {"__metadata__": metadata}
    offset = 0
    for name, shape, data in tensors:
        header[name] = {"dtype": "F32", "shape": list(shape), "data_offsets": [offset, offset + len(data)]}
        offset += len(data)
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    temporary = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(temporary, "wb") as file:
            file.write(struct.pack("<Q", len(text)) + text)
            for _, _, data in tensors:
                file.write(data)
        os.replace(temporary, path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise _Failure(f"{error.strerror}", path) from None


def found() -> list[Path]:
    """The files that torchvision has downloaded, and those of the package lpips, where these are on this machine."""
    home = os.environ.get("TORCH_HOME") or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "torch"
    names = ("alexnet-*.pth", "squeezenet1_1-*.pth", "vgg16-*.pth")
    files = [path for name in names for path in sorted((Path(home) / "hub" / "checkpoints").glob(name))]
    package = importlib.util.find_spec("lpips")
    for folder in (package.submodule_search_locations or []) if package else []:
        files += [p for p in (Path(folder, "weights", "v0.1", f"{n}.pth") for n in ("alex", "squeeze")) if p.is_file()]
    return files


@checked
def convert(files: Sequence[PathLike], folder: PathLike) -> list[Path]:
    """Turns PyTorch files of any order and name into what ffprocams reads.

    Returns the files written into `folder`: of each network whose backbone is among `files`, with its heads if it is
    for LPIPS. Fails where a file is unknown, or where heads or backbone are missing for all.
    Raises FileFormatError in these cases.
    """
    parts: dict[tuple[str, str], tuple[dict[str, Any], Path]] = {}
    for path in map(Path, files):
        state = _load(path)
        part = _recognise(state)
        if part is None:
            raise _Failure("neither AlexNet, SqueezeNet 1.1, VGG16 nor LPIPS 0.1 heads of the first two", path)
        if part in parts:
            raise _Failure(f"{part[1]} of {part[0]} twice ({parts[part][1]}, {path})")
        parts[part] = state, path
    written = []
    for name, network in NETWORKS.items():
        if (name, "backbone") not in parts or (network["heads"] and (name, "heads") not in parts):
            continue
        state, path = parts[name, "backbone"]
        tensors = [_take(state, path, tensor, tensor, shape) for tensor, shape in network["backbone"]]
        for i, channels in enumerate(network["heads"]):
            state, path = parts[name, "heads"]
            tensors.append(_take(state, path, _head(i), f"lin{i}.weight", (1, channels, 1, 1)))
        written.append(Path(folder) / network["file"])
        _write(written[-1], tensors, network["metadata"])
    if not written:
        have = ", ".join(f"{part} of {name}" for name, part in parts) or "none"
        raise _Failure(f"no network is complete: LPIPS needs backbone and heads (there are: {have})")
    return written


def main(arguments: Sequence[str] | None = None) -> None:
    """The command. Raises SystemExit with the message of what convert raises."""
    parser = argparse.ArgumentParser(
        prog="python -m ffprocams.perceptual",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="*", metavar="FILE.pth")
    parser.add_argument("-o", "--output", metavar="FOLDER", required=True, help="folder for the weights")
    given = parser.parse_args(arguments)
    try:
        written = convert(given.files or found(), given.output)
    except _Failure as failure:
        sys.exit(f"{parser.prog}: error: {failure}")
    for path in written:
        print(path)
    if any(path.name == "lpips_alex.safetensors" for path in written):
        print(f"LPIPS is computed where FFPROCAMS_PERCEPTUAL={Path(given.output).resolve()} is in the environment")


if __name__ == "__main__":
    main()
