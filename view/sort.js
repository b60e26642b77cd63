'use strict';
// The order of the splats as a device sees them, far to near. As in engine/render/bin.c keys are the bits of the
// depth, which for positive numbers sort as the numbers do; splats of equal depth keep the set's order, reversed
// from far to near.

const ROW = 2048; // texels in a row of the splats' textures

class DepthSorter {
  constructor(splats) {
    const n = splats.count;
    this.splats = splats;
    this.depth = new Float32Array(n);
    this.key = new Uint32Array(this.depth.buffer);
    this.order = new Uint32Array(Math.ceil((n + 1) / ROW) * ROW); // whole rows of a texture
    this.swap = new Uint32Array(n);
    this.start = new Uint32Array(1 << 16);
  }

  // One digit of 16 bits, of the `count` splats in `from`; the largest digit comes first.
  pass(from, to, count, shift) {
    const {key, start} = this;
    start.fill(0);
    for (let i = 0; i < count; i++) start[(key[from[i]] >>> shift) & 65535]++;
    let total = 0;
    for (let d = 65535; d >= 0; d--) {
      const here = start[d];
      start[d] = total;
      total += here;
    }
    for (let i = 0; i < count; i++) to[start[(key[from[i]] >>> shift) & 65535]++] = from[i];
  }

  // Returns how many splats lie in front of the device; `order` then holds them.
  sort(pose) {
    const {splats, depth, order, swap} = this, c = splats.centre;
    const zx = pose[2], zy = pose[6], zz = pose[10];
    const offset = pose[3] * zx + pose[7] * zy + pose[11] * zz;
    let count = 0;
    for (let i = splats.count - 1; i >= 0; i--) {
      depth[i] = c[3 * i] * zx + c[3 * i + 1] * zy + c[3 * i + 2] * zz - offset;
      if (depth[i] > 0) order[count++] = i;
    }
    this.pass(order, swap, count, 0);
    this.pass(swap, order, count, 16);
    return count;
  }
}
