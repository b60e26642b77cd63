#!/usr/bin/env python3
"""bench/peers/torch_network.py MODEL.safetensors INPUTS [--gradient FILE] [--how eager|compile] [--bf16] [--threads 1]

The encoder (tokeniser, blocks, last norm) of ffprocams.torch.Network, run once for every line that is asked for: `run` and `write FILE`, as
encoder_times has them (bench/encoder_times.c). Needs the Python package and PyTorch.
"""
import argparse
import sys
import time

import numpy
import torch

from ffprocams import torch as layer


def halved(network):
    """Weights that are not trained are turned to bf16 once, as who cares for speed would; in training they stay float32 (autocast turns them)."""
    for name, weight in network.named_parameters():
        if weight.dim() == 2 and not name.endswith("_conv"):
            weight.data = weight.data.bfloat16()


class Worker:
    """One form of the network, run and timed on demand."""

    def __init__(self, options):
        self.network = layer.Network(options.model)
        columns = self.network.at("tokeniser.weight").shape[1]
        self.inputs = torch.from_numpy(numpy.fromfile(options.inputs, "<f4").reshape(-1, columns))
        if options.bf16 and not options.gradient:
            halved(self.network)
        self.gradient = options.gradient and torch.from_numpy(numpy.fromfile(options.gradient, "<f4").reshape(-1, self.network.form.dim))
        self.bf16 = options.bf16
        self.network.requires_grad_(self.gradient is not None)
        self.call = torch.compile(self.network.encode) if options.how == "compile" else self.network.encode

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
        """The values that `write` writes: the outputs, and the gradients of the weights in the order of the file."""
        yield self.output.detach().float().numpy()
        if self.gradient is not None:
            for name in self.network.names[: self.network.names.index("final_norm") + 1]:
                yield self.network.at(name).grad.float().numpy()


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
