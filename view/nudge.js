'use strict';
// A projector's pose found again by hand: each pull says of a point of the object which pixel of the projector lights it. No
// document, no drawing: tests run it alone.

const PULLS_MAX = 12, PULL_PRIOR = [0.1, 0.02], PULL_SIGMA = 1.5; // expected turns (radians), shifts (shares of the distance), errors of a hand (pixels)

// x with A x = b by Gaussian elimination with pivots; A n x n, both are lost.
function solveLinear(A, b) {
  const n = b.length;
  for (let k = 0; k < n; k++) {
    let best = k;
    for (let i = k + 1; i < n; i++) if (Math.abs(A[i][k]) > Math.abs(A[best][k])) best = i;
    [A[k], A[best]] = [A[best], A[k]], [b[k], b[best]] = [b[best], b[k]];
    for (let i = k + 1; i < n; i++) {
      const f = A[i][k] / A[k][k];
      for (let j = k; j < n; j++) A[i][j] -= f * A[k][j];
      b[i] -= f * b[k];
    }
  }
  for (let k = n - 1; k >= 0; k--) {
    for (let j = k + 1; j < n; j++) b[k] -= A[k][j] * b[j];
    b[k] /= A[k][k];
  }
  return b;
}

// The pose turned by three radians and shifted by three shares of `distance` along its own axes.
function movedPose(pose, by, distance) {
  const angle = length3(by), eye = positionOf(pose), own = [0, 1, 2].map((k) => axisOf(pose, k)), mix = (v) => add3(add3(scale3(own[0], v[0]), scale3(own[1], v[1])), scale3(own[2], v[2]));
  const turned = angle > 0 ? turnPose(pose, normalise3(mix(by)), angle, eye) : pose;
  return movePose(turned, scale3(mix(by.slice(3)), distance));
}

// The pose nearest to the device's under which it lights each pull's `point` by its `pixel`: Gauss-Newton with a prior, so
// that one pull mostly turns, and three or more determine all. `distance`: of the device from the object.
function poseOfPulls(device, pulls, distance) {
  const sum = [0, 0, 0, 0, 0, 0], prior = [0, 0, 0, 1, 1, 1].map((k) => 1 / PULL_PRIOR[k] ** 2);
  let {pose} = device;
  for (let step = 0; step < 20; step++) {
    const A = sum.map((_, i) => sum.map((__, j) => i === j ? prior[i] : 0)), b = sum.map((x, i) => -prior[i] * x);
    for (const {point, pixel} of pulls) {
      const here = project({...device, pose}, point);
      if (!(here[2] > 0)) return null;
      const slopes = sum.map((_, i) => {
        const by = sum.map((__, j) => i === j ? 1e-5 : 0), there = project({...device, pose: movedPose(pose, by, distance)}, point);
        return [0, 1].map((k) => (there[k] - here[k]) / 1e-5);
      });
      for (let k = 0; k < 2; k++)
        for (let i = 0; i < 6; i++) {
          b[i] += slopes[i][k] * (pixel[k] - here[k]) / PULL_SIGMA ** 2;
          for (let j = 0; j < 6; j++) A[i][j] += slopes[i][k] * slopes[j][k] / PULL_SIGMA ** 2;
        }
    }
    const by = solveLinear(A, b);
    if (!by.every(Number.isFinite)) return null;
    by.forEach((x, i) => { sum[i] += x; });
    pose = movedPose(pose, by, distance);
    if (Math.max(...by.map(Math.abs)) < 1e-9) break;
  }
  return pose;
}

// The mean distance, pixels, by which pulls are still off.
const missOf = (device, pulls) => pulls.reduce((sum, {point, pixel}) => {
  const [x, y] = project(device, point);
  return sum + Math.hypot(x - pixel[0], y - pixel[1]);
}, 0) / pulls.length;
