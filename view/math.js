'use strict';
// Vectors are arrays of 3, poses row-major arrays of 16, device to world, rigid; devices are pinholes
// {width, height, fx, fy, cx, cy, pose} with axes x right, y down, z forward and pixel centres at + 0.5.

const add3 = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub3 = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scale3 = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot3 = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross3 = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length3 = (a) => Math.hypot(a[0], a[1], a[2]);
const normalise3 = (a) => scale3(a, 1 / (length3(a) || 1));

const positionOf = (pose) => [pose[3], pose[7], pose[11]];
const axisOf = (pose, k) => [pose[k], pose[4 + k], pose[8 + k]];

function poseOf(axes, position) {
  const [x, y, z] = axes, p = position;
  return [x[0], y[0], z[0], p[0], x[1], y[1], z[1], p[1], x[2], y[2], z[2], p[2], 0, 0, 0, 1];
}

// A device at `position` that looks at `target`, its y axis as far down as that allows.
function lookAt(position, target, up) {
  const z = normalise3(sub3(target, position));
  let x = cross3(z, up);
  if (length3(x) < 1e-6) x = cross3(z, Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]);
  x = normalise3(x);
  return poseOf([x, cross3(z, x), z], position);
}

// `v` turned about the unit `axis` (Rodrigues).
function turn3(v, axis, angle) {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add3(add3(scale3(v, c), scale3(cross3(axis, v), s)), scale3(axis, dot3(axis, v) * (1 - c)));
}

// The whole device turned about an axis through a point.
function turnPose(pose, axis, angle, about) {
  const axes = [0, 1, 2].map((k) => turn3(axisOf(pose, k), axis, angle));
  // rounding must not add up over many small turns
  const z = normalise3(axes[2]), x = normalise3(cross3(axes[1], z)), y = cross3(z, x);
  return poseOf([x, y, z], add3(about, turn3(sub3(positionOf(pose), about), axis, angle)));
}

function movePose(pose, by) {
  const out = pose.slice();
  for (let k = 0; k < 3; k++) out[4 * k + 3] += by[k];
  return out;
}

// As ffp_project: [x, y, depth].
function project(device, point) {
  const d = sub3(point, positionOf(device.pose));
  const q = [0, 1, 2].map((k) => dot3(axisOf(device.pose, k), d));
  return [device.cx + device.fx * q[0] / q[2], device.cy + device.fy * q[1] / q[2], q[2]];
}

// World direction of the ray through pixel position (x, y), of length 1 along the device's axis.
function rayThrough(device, x, y) {
  const ray = [(x - device.cx) / device.fx, (y - device.cy) / device.fy, 1];
  return [0, 1, 2].map((r) => dot3(device.pose.slice(4 * r, 4 * r + 3), ray));
}

// As ffp_surface_point.
const pointAt = (device, x, y, z) => add3(positionOf(device.pose), scale3(rayThrough(device, x, y), z));

// The same device for pictures of another size: its field of view fits in, and the rest shows more.
function fitDevice(device, width, height, zoom = 1) {
  const s = Math.min(width / device.width, height / device.height) * zoom;
  return {
    width, height, fx: device.fx * s, fy: device.fy * s, pose: device.pose,
    cx: width / 2 + (device.cx - device.width / 2) * s, cy: height / 2 + (device.cy - device.height / 2) * s,
  };
}

// As sample_camera in engine/render/pass.c: a pixel for each of side x side samples.
const sampleDevice = (d, side) => ({
  width: d.width * side, height: d.height * side, fx: d.fx * side, fy: d.fy * side, cx: d.cx * side,
  cy: d.cy * side, pose: d.pose,
});

// The same view in another number of pixels.
function scaleDevice(d, width, height) {
  const sx = width / d.width, sy = height / d.height;
  return {width, height, fx: d.fx * sx, fy: d.fy * sy, cx: d.cx * sx, cy: d.cy * sy, pose: d.pose};
}

// As shadow_camera in engine/render/mapping.c.
function shadowDevice(projector, side) {
  const share = side / Math.max(projector.width, projector.height);
  return scaleDevice(projector, Math.max(1, Math.floor(projector.width * share)), Math.max(1, Math.floor(projector.height * share)));
}

const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
