#!/usr/bin/env python3
"""Turns downloaded PyTorch weights into the safetensors files that ffprocams reads for LPIPS and the perceptual loss.

The weights are other people's work and are not part of this project. Download them yourself, then convert:

    convert_perceptual.py alex    alexnet-owt-7be5be79.pth  alex.pth     lpips_alex.safetensors
    convert_perceptual.py squeeze squeezenet1_1-b8a52dc0.pth squeeze.pth lpips_squeeze.safetensors
    convert_perceptual.py vgg16   vgg16-397923af.pth                     vgg16_relu2_2.safetensors

The first file of each line holds torchvision's ImageNet weights (https://download.pytorch.org/models/NAME). The second,
for LPIPS, holds the linear heads of version 0.1: lpips/weights/v0.1/alex.pth and squeeze.pth of the Python package
"lpips" (https://github.com/richzhang/PerceptualSimilarity). Only torch is needed, to open the .pth files.

Put the three results into one folder and give that folder or a file of it to ffprocams where a path to perceptual
weights is asked for.
"""

import argparse
import array
import json
import os
import struct
import sys


def fail(what, where):
    sys.exit(f"convert_perceptual.py: error: {what} ({where})")


def conv(name, out_channels, in_channels, kernel):
    """The two tensors of one convolution: (name, shape)."""
    return [
        (name + ".weight", (out_channels, in_channels, kernel, kernel)),
        (name + ".bias", (out_channels,)),
    ]


def fire(index, inputs, squeeze, expand):
    """One SqueezeNet module: 1x1 down, then 1x1 and 3x3 up."""
    name = f"features.{index}."
    return (
        conv(name + "squeeze", squeeze, inputs, 1)
        + conv(name + "expand1x1", expand, squeeze, 1)
        + conv(name + "expand3x3", expand, squeeze, 3)
    )


# What each network's backbone holds, in file order, the channels of its heads, and the file's metadata.
NETWORKS = {
    "alex": {
        "backbone": conv("features.0", 64, 3, 11)
        + conv("features.3", 192, 64, 5)
        + conv("features.6", 384, 192, 3)
        + conv("features.8", 256, 384, 3)
        + conv("features.10", 256, 256, 3),
        "heads": (64, 192, 384, 256, 256),
        "metadata": {
            "network": "alex",
            "version": "0.1",
            "backbone": "torchvision ImageNet weights",
            "input": "RGB in [-1,1]",
        },
    },
    "squeeze": {
        "backbone": conv("features.0", 64, 3, 3)
        + fire(3, 64, 16, 64)
        + fire(4, 128, 16, 64)
        + fire(6, 128, 32, 128)
        + fire(7, 256, 32, 128)
        + fire(9, 256, 48, 192)
        + fire(10, 384, 48, 192)
        + fire(11, 384, 64, 256)
        + fire(12, 512, 64, 256),
        "heads": (64, 128, 256, 384, 384, 512, 512),
        "metadata": {
            "network": "squeeze",
            "version": "0.1",
            "backbone": "torchvision ImageNet weights",
            "input": "RGB in [-1,1]",
        },
    },
    "vgg16": {
        "backbone": conv("features.0", 64, 3, 3)
        + conv("features.2", 64, 64, 3)
        + conv("features.5", 128, 64, 3)
        + conv("features.7", 128, 128, 3),
        "heads": (),
        "metadata": {
            "network": "vgg16 up to relu2_2",
            "backbone": "torchvision ImageNet weights",
            "input": "RGB, ImageNet mean/std",
        },
    },
}


def load(path):
    """The name -> tensor table of a .pth file. weights_only: a file from the net must not run code here."""
    try:
        import torch
    except ImportError:
        fail("this needs PyTorch: pip install torch", "import torch")
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
    except OSError as error:
        fail(error.strerror, path)
    except Exception:  # torch names no common type for what a damaged file raises
        fail("not a file of PyTorch weights", path)
    if not isinstance(state, dict):
        fail("not a table of tensors", path)
    return state


def take(state, path, stored_name, name, shape):
    """One tensor as (name, shape, little-endian fp32 bytes)."""
    if stored_name not in state:
        fail("no such tensor", f"{path}: {stored_name}")
    tensor = state[stored_name]
    if tuple(tensor.shape) != shape:
        fail(f"shape {tuple(tensor.shape)}, not {shape}", f"{path}: {stored_name}")
    values = array.array("f", tensor.detach().float().flatten().tolist())
    if sys.byteorder == "big":
        values.byteswap()
    return name, shape, values.tobytes()


def write_safetensors(path, tensors, metadata):
    """Length of the header, header (JSON, padded with spaces to a multiple of 8), data; renamed into place when whole."""
    header, offset = {"__metadata__": metadata}, 0
    for name, shape, data in tensors:
        header[name] = {"dtype": "F32", "shape": list(shape), "data_offsets": [offset, offset + len(data)]}
        offset += len(data)
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    temporary = f"{path}.{os.getpid()}.tmp"
    try:
        with open(temporary, "wb") as file:
            file.write(struct.pack("<Q", len(text)) + text)
            for _, _, data in tensors:
                file.write(data)
        os.replace(temporary, path)
    except OSError as error:
        if os.path.exists(temporary):
            os.remove(temporary)
        fail(error.strerror, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("network", choices=sorted(NETWORKS))
    parser.add_argument("files", nargs="+", metavar="FILE", help="BACKBONE.pth [HEADS.pth] OUTPUT.safetensors")
    arguments = parser.parse_args()
    network = NETWORKS[arguments.network]
    if len(arguments.files) != (3 if network["heads"] else 2):
        parser.error("vgg16 takes BACKBONE.pth OUTPUT.safetensors; alex and squeeze take HEADS.pth between the two")

    backbone_path, output = arguments.files[0], arguments.files[-1]
    backbone = load(backbone_path)
    tensors = [take(backbone, backbone_path, name, name, shape) for name, shape in network["backbone"]]
    if network["heads"]:
        heads_path = arguments.files[1]
        heads = load(heads_path)
        for i, channels in enumerate(network["heads"]):
            stored = f"lin{i}.model.1.weight"
            tensors.append(take(heads, heads_path, stored, f"lin{i}.weight", (1, channels, 1, 1)))
    write_safetensors(output, tensors, network["metadata"])
    print(f"{output}: {len(tensors)} tensors")


if __name__ == "__main__":
    main()
