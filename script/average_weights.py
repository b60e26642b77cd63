#!/usr/bin/env python3
"""Averages weights files of one configuration.

usage: script/average_weights.py OUT.safetensors A.safetensors SHARE B.safetensors SHARE ...

Networks that were trained from one another lie in one valley, and the mean of their weights is often better
than each (Wortsman et al. 2022, "Model soups"). Shares should add up to 1. Parameters that a file lacks are
taken for zeros. The first file's metadata goes on, with an "origin" that names all files and shares.
"""
import json
import os
import struct
import sys

import numpy as np


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    size = struct.unpack("<Q", data[:8])[0]
    return json.loads(data[8 : 8 + size]), data[8 + size :]


def numbers(entry, data):
    begin, end = entry["data_offsets"]
    if entry["dtype"] == "BF16":
        bits = np.frombuffer(data[begin:end], np.uint16).astype(np.uint32) << 16
        return bits.view(np.float32)
    if entry["dtype"] != "F32":
        sys.exit(f"error: {entry['dtype']} is not a type of weights")
    return np.frombuffer(data[begin:end], np.float32)


def packed(values, dtype):
    values = values.astype(np.float32)
    if dtype == "F32":
        return values.tobytes()
    bits = values.view(np.uint32)
    return ((bits + 0x7FFF + ((bits >> 16) & 1)) >> 16).astype(np.uint16).tobytes()  # to nearest, ties to even


def main():
    if len(sys.argv) < 6 or len(sys.argv) % 2:
        sys.exit(__doc__)
    files = [(path, float(share)) for path, share in zip(sys.argv[2::2], sys.argv[3::2])]
    headers = [(read(path), share) for path, share in files]
    (header, first), _ = headers[0]
    out = bytearray(first)
    for name, entry in header.items():
        if name == "__metadata__":
            continue
        total = 0
        for (other, data), share in headers:
            if name in other:
                if other[name]["shape"] != entry["shape"]:
                    sys.exit(f"error: {name} has other shapes")
                total = total + share * numbers(other[name], data)
        begin, end = entry["data_offsets"]
        out[begin:end] = packed(total, entry["dtype"])
    names = ", ".join(f"{share:g} of {os.path.basename(path)}" for path, share in files)
    header["__metadata__"]["origin"] = f"mean of {names}; {header['__metadata__'].get('origin', '')}"[:250]
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    with open(sys.argv[1] + ".tmp", "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text + bytes(out))
    os.replace(sys.argv[1] + ".tmp", sys.argv[1])


main()
