'use strict';
// Drawn over the picture: the projectors' frusta, each with a handle, and the brush.

const HANDLE = 13; // radius on the screen, pixels

// Corners of the projector's pattern where it is in focus: at the object's centre.
function frustumCorners(app, device) {
  const depth = Math.max(app.renderer.centreDepth(device), 0.05 * (app.scene.radius || 1));
  return [[0, 0], [device.width, 0], [device.width, device.height], [0, device.height]].map(
    ([x, y]) => pointAt(device, x, y, depth));
}

// On the screen, or null behind the camera.
function onScreen(camera, point) {
  const [x, y, z] = project(camera, point);
  return z > 1e-6 ? [x, y] : null;
}

// The place of a projector's handle; at the screen's edge if the projector is outside the screen.
function handleOf(app, projector) {
  const camera = app.screenCamera(), at = onScreen(camera, positionOf(projector.device.pose));
  const [width, height] = app.freeSize(), margin = 26, middle = [width / 2, height / 2];
  const inside = at && at[0] > margin && at[1] > margin && at[0] < width - margin && at[1] < height - margin;
  if (inside) return {at, inside};
  let away;
  if (at) away = [at[0] - middle[0], at[1] - middle[1]];
  else {
    const d = sub3(positionOf(projector.device.pose), positionOf(camera.pose));
    away = [dot3(d, axisOf(camera.pose, 0)), dot3(d, axisOf(camera.pose, 1)) || 1e-6];
  }
  const s = Math.min((middle[0] - margin) / (Math.abs(away[0]) || 1e-9), (middle[1] - margin) / (Math.abs(away[1]) || 1e-9));
  return {at: [middle[0] + away[0] * s, middle[1] + away[1] * s], inside: false};
}

// From a handle at the screen's edge to where the projector is.
function drawArrow(context, app, at) {
  const [width, height] = app.freeSize(), angle = Math.atan2(at[1] - height / 2, at[0] - width / 2);
  context.save();
  context.translate(...at);
  context.rotate(angle);
  context.beginPath();
  context.moveTo(HANDLE + 9, 0), context.lineTo(HANDLE + 1, -6), context.lineTo(HANDLE + 1, 6);
  context.fill();
  context.restore();
}

function drawFrustum(context, app, projector, selected) {
  const camera = app.screenCamera();
  const corners = frustumCorners(app, projector.device).map((p) => onScreen(camera, p));
  const apex = onScreen(camera, positionOf(projector.device.pose)), handle = handleOf(app, projector);
  context.strokeStyle = context.fillStyle = projector.colour;
  context.globalAlpha = (selected ? 0.9 : 0.4) * (projector.on ? 1 : 0.4);
  context.lineWidth = selected ? 1.5 : 1;
  if (corners.every(Boolean)) {
    context.beginPath();
    corners.forEach(([x, y], k) => k ? context.lineTo(x, y) : context.moveTo(x, y));
    context.closePath();
    context.setLineDash([5, 5]);
    context.stroke();
    context.setLineDash([]);
    context.beginPath(); // which side is up
    context.moveTo(...corners[0]), context.lineTo(...corners[1]);
    context.lineWidth *= 2;
    context.stroke();
    context.lineWidth /= 2;
    if (apex) {
      context.globalAlpha *= 0.55;
      context.beginPath();
      for (const corner of corners) context.moveTo(...apex), context.lineTo(...corner);
      context.stroke();
      context.globalAlpha /= 0.55;
    }
  }
  context.globalAlpha = projector.on ? 1 : 0.5;
  context.beginPath();
  context.arc(...handle.at, HANDLE - (selected ? 0 : 3), 0, 2 * Math.PI);
  context.fill();
  if (!handle.inside) drawArrow(context, app, handle.at);
  context.fillStyle = '#16110a', context.font = '600 12px system-ui', context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.fillText(projector.number, ...handle.at);
  context.globalAlpha = 1;
}

function drawOverlay(app) {
  const {overlay} = app, context = overlay.getContext('2d'), ratio = devicePixelRatio || 1;
  const width = Math.round(innerWidth * ratio), height = Math.round(innerHeight * ratio);
  if (overlay.width !== width || overlay.height !== height) overlay.width = width, overlay.height = height;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, innerWidth, innerHeight);
  if (app.frusta)
    for (const projector of app.projectors)
      if (app.mode !== 'brush' || projector === app.projector) drawFrustum(context, app, projector, projector === app.projector);
  if (app.choosing) app.choosing.drawInView(context);
  if (app.mode === 'nudge' && app.pull) {
    context.strokeStyle = context.fillStyle = app.projector.colour, context.lineWidth = 2;
    context.beginPath();
    context.moveTo(...app.pull[0]), context.lineTo(...app.pull[1]);
    context.stroke();
    context.beginPath();
    context.arc(...app.pull[1], 5, 0, 2 * Math.PI);
    context.fill();
  }
  if (app.mode === 'brush' && app.pointer) {
    context.strokeStyle = app.brush.erase ? '#fff' : app.brush.colour, context.lineWidth = 2;
    context.beginPath();
    context.arc(...app.pointer, app.brush.size, 0, 2 * Math.PI);
    context.stroke();
  }
}
