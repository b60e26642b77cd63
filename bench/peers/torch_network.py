#!/usr/bin/env python3
"""bench/peers/torch_network.py MODEL.safetensors INPUTS [--gradient FILE] [--how eager|compile] [--bf16] [--threads 1]

The encoder (tokeniser, blocks, last norm; docs/design/architecture.md, src/engine/network) in PyTorch, reading the same weights, and run once for every line
that is asked for: `run` and `write FILE`, as encoder_times has them (bench/encoder_times.c). The state-space scan is the chunked form of Dao and
Gu 2024 (Sec. 6, block decomposition), in batched products. Needs torch and numpy.
"""
import argparse
import json
import struct
import sys
import time

import numpy
import torch
import torch.nn.functional as F

HEAD_DIM, TAPS, EPSILON = 64, 4, 1e-5


def read_weights(path):
    """The header's metadata and the tensors by name, in float32: safetensors is a length, a JSON header and raw numbers."""
    with open(path, "rb") as file:
        header = json.loads(file.read(struct.unpack("<Q", file.read(8))[0]))
        data = file.read()
    metadata, tensors = header.pop("__metadata__"), {}
    for name, entry in header.items():
        kind = {"F32": torch.float32, "BF16": torch.bfloat16}[entry["dtype"]]
        begin, end = entry["data_offsets"]
        tensors[name] = torch.frombuffer(bytearray(data[begin:end]), dtype=kind).reshape(entry["shape"]).float()
    return metadata, tensors


def scan(x, b, c, dt, rate, skip, chunk, reverse):
    """y [T, heads, width] of h_t = exp(dt rate) h_{t-1} + dt x_t (outer) B_t, y_t = h_t C_t + skip x_t; x [T, heads, width], b and c [T, state], dt
    [T, heads], rate and skip [heads]. Chunks stay in the rows' order; a reversed scan turns sums, masks and the chunks' order."""
    rows, heads, width = x.shape
    chunks = rows // chunk
    x_, b_, c_ = (v.reshape(chunks, chunk, -1) for v in (x, b, c))
    by_head = x_.unflatten(2, (heads, width))
    dt_ = dt.reshape(chunks, chunk, heads)
    square = torch.ones(chunk, chunk, dtype=torch.bool)
    before = torch.ones(chunks, chunks, dtype=torch.bool)
    seen, before = (square.triu(), before.triu(1)) if reverse else (square.tril(), before.tril(-1))

    def running(values, dim):
        return values.flip(dim).cumsum(dim).flip(dim) if reverse else values.cumsum(dim)

    def decays(to, since, where):
        """exp(to_i - since_j) where i sees j, otherwise 0."""
        return (to.unsqueeze(-1) - since.unsqueeze(-2)).masked_fill(~where, -torch.inf).exp()

    sums = running(dt_ * rate, 1)  # [chunks, chunk, heads], a row's own step included
    total = sums[:, 0 if reverse else -1]  # [chunks, heads]
    # What rows give to the rows of their chunk.
    pairs = torch.bmm(c_, b_.transpose(1, 2))  # [chunks, chunk, chunk], shared by the heads
    turned = sums.transpose(1, 2)
    weights = decays(turned, turned, seen) * pairs.unsqueeze(1) * dt_.transpose(1, 2).unsqueeze(2)
    inside = torch.matmul(weights, by_head.transpose(1, 2)).transpose(1, 2)  # [chunks, chunk, heads, width]
    # What each chunk adds to the state; the states that enter the chunks, and what these give.
    feed = (dt_ * (total.unsqueeze(1) - sums).exp()).unsqueeze(-1) * by_head
    own = torch.bmm(b_.transpose(1, 2), feed.flatten(2))  # [chunks, state, heads width]
    left = running(total, 0).transpose(0, 1)  # [heads, chunks]
    entered = left - total.transpose(0, 1)
    entering = torch.einsum("hij,jnhp->inhp", decays(entered, left, before), own.unflatten(2, (heads, width)))
    outside = torch.bmm(c_, entering.flatten(2)).unflatten(2, (heads, width))
    y = inside + outside * sums.exp().unsqueeze(-1)
    return y.reshape(rows, heads, width) + skip.unsqueeze(-1) * x


class Encoder(torch.nn.Module):
    def __init__(self, metadata, tensors, matrices):
        """`matrices`: the type in which matrices are kept."""
        super().__init__()
        self.modules_ = metadata["model.modules"]
        self.dim, self.state, self.chunk = (int(metadata["model." + key]) for key in ("dim", "state", "chunk"))
        names = list(tensors)
        self.order = names[: names.index("final_norm") + 1]
        for name in self.order:
            value = tensors[name].to(matrices if tensors[name].dim() == 2 and not name.endswith(".conv") else torch.float32)
            self.register_parameter(name.replace(".", "_"), torch.nn.Parameter(value))

    def at(self, *names):
        return getattr(self, "_".join(str(name) for name in names))

    def mamba(self, x, i):
        at = lambda *names: self.at("blocks", i, *names)
        inner, heads = 2 * self.dim, 2 * self.dim // HEAD_DIM
        convolved = inner + 2 * self.state
        row = F.linear(F.rms_norm(x, (self.dim,), at("norm"), EPSILON), at("in_proj"))
        z, columns, raw = row.split((inner, convolved, heads), -1)
        gate = F.silu(z.float())
        columns = columns.transpose(0, 1)
        summed = 0
        for direction in ("forward", "reverse"):
            reverse = direction == "reverse"
            taps = at(direction, "conv").to(columns.dtype).unsqueeze(1)
            padded = F.pad(columns, (0, TAPS - 1) if reverse else (TAPS - 1, 0))
            turned = F.conv1d(padded, taps.flip(-1) if reverse else taps, at(direction, "conv_bias").to(columns.dtype), groups=convolved)
            u, b, c = F.silu(turned).transpose(0, 1).contiguous().split((inner, self.state, self.state), -1)
            dt = F.softplus(raw.float() + at(direction, "dt_bias"))
            y = scan(u.unflatten(1, (heads, HEAD_DIM)), b, c, dt, -at(direction, "a_log").exp(), at(direction, "d"), self.chunk, reverse)
            summed = summed + F.rms_norm(y.flatten(1) * gate, (inner,), at(direction, "norm"), EPSILON)
        return x + F.linear(summed, at("out_proj"))

    def transformer(self, x, i):
        at = lambda *names: self.at("blocks", i, *names)
        heads = self.dim // HEAD_DIM
        rows = F.linear(F.layer_norm(x, (self.dim,), at("norm1"), None, EPSILON), at("qkv"))
        q, k, v = rows.unflatten(1, (3, heads, HEAD_DIM)).permute(1, 2, 0, 3).unsqueeze(1)
        q = F.rms_norm(q.float(), (HEAD_DIM,), at("q_gain"), EPSILON).to(v.dtype)
        k = F.rms_norm(k.float(), (HEAD_DIM,), at("k_gain"), EPSILON).to(v.dtype)
        attended = F.scaled_dot_product_attention(q, k, v)[0].transpose(0, 1).flatten(1)
        x = x + F.linear(attended, at("proj"))
        hidden = F.linear(F.layer_norm(x, (self.dim,), at("norm2"), None, EPSILON), at("fc1"))
        return x + F.linear(F.gelu(hidden), at("fc2"))

    def forward(self, inputs):
        x = F.layer_norm(F.linear(inputs, self.tokeniser_weight).float(), (self.dim,), self.tokeniser_norm, None, EPSILON)
        for i, kind in enumerate(self.modules_):
            x = self.mamba(x, i) if kind == "M" else self.transformer(x, i)
        return F.layer_norm(x.float(), (self.dim,), self.final_norm, None, EPSILON)


class Worker:
    """One form of the network, run and timed on demand."""

    def __init__(self, options):
        metadata, tensors = read_weights(options.model)
        columns = tensors["tokeniser.weight"].shape[1]
        self.inputs = torch.from_numpy(numpy.fromfile(options.inputs, "<f4").reshape(-1, columns))
        chunk = int(metadata["model.chunk"])
        if len(self.inputs) % chunk:
            sys.exit(f"torch_network: error: {options.inputs}: {len(self.inputs)} tokens are not a multiple of the chunk, {chunk}")
        # Weights that are not trained are turned to bf16 once, as who cares for speed would; in training they stay float32 (autocast turns them).
        once = options.bf16 and not options.gradient
        self.network = Encoder(metadata, tensors, torch.bfloat16 if once else torch.float32)
        self.gradient = options.gradient and torch.from_numpy(numpy.fromfile(options.gradient, "<f4").reshape(-1, self.network.dim))
        self.bf16 = options.bf16
        self.network.requires_grad_(self.gradient is not None)
        self.call = torch.compile(self.network) if options.how == "compile" else self.network

    def run(self):
        if self.gradient is None:
            with torch.inference_mode(), torch.autocast("cpu", torch.bfloat16, enabled=self.bf16):
                self.output = self.call(self.inputs)
            return
        self.network.zero_grad(set_to_none=True)
        with torch.autocast("cpu", torch.bfloat16, enabled=self.bf16):
            self.output = self.call(self.inputs)
        self.output.backward(self.gradient)

    def results(self):
        """What `write` writes: the outputs, and the gradients of the weights in the order of the file."""
        yield self.output.detach().float().numpy()
        if self.gradient is not None:
            for name in self.network.order:
                yield self.network.at(name.replace(".", "_")).grad.float().numpy()


def serve(worker):
    for line in sys.stdin:
        command, _, path = line.rstrip("\n").partition(" ")
        if command == "run":
            wall, processor = time.perf_counter(), time.process_time()
            worker.run()
            print(f"{time.process_time() - processor:.6f} {time.perf_counter() - wall:.6f}", flush=True)
        elif command == "write" and path:
            with open(path, "wb") as file:
                for array in worker.results():
                    file.write(numpy.ascontiguousarray(array, "<f4").tobytes())
            print("written", flush=True)
        else:
            sys.exit(f"torch_network: error: {line.rstrip()}: neither `run` nor `write FILE`")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", help="weights of the project")
    parser.add_argument("inputs", help="float32 [tokens, patch^2 channels]")
    parser.add_argument("--gradient", help="float32 [tokens, dim]: of the outputs; a run is then the forward and the backward pass")
    parser.add_argument("--how", choices=("eager", "compile"), default="eager")
    parser.add_argument("--bf16", action="store_true", help="autocast to bf16; without --gradient matrices are bf16 from the start")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    worker = Worker(options)
    worker.run()  # compiles
    print(f"ready {torch.__version__} {torch.backends.cpu.get_cpu_capability()}", flush=True)
    serve(worker)


if __name__ == "__main__":
    main()
