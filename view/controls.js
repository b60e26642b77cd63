'use strict';
// Control of camera, projectors and brush by mouse, touch and wheel.

const TURN = 0.0065; // radians per pixel

// Like a turntable: across about `up`, and over towards the poles but not beyond.
function orbit(pose, target, up, across, over) {
  const turned = turnPose(pose, up, across, target), tilted = turnPose(turned, axisOf(turned, 0), over, target);
  const height = (p) => Math.abs(dot3(normalise3(sub3(positionOf(p), target)), up));
  return height(tilted) > 0.995 && height(tilted) > height(turned) ? turned : tilted; // what starts there comes away
}

// Like a head: across about `up`, and over towards zenith and nadir but not beyond.
function lookAround(pose, up, across, over) {
  const eye = positionOf(pose), turned = turnPose(pose, up, across, eye), tilted = turnPose(turned, axisOf(turned, 0), over, eye);
  const height = (p) => Math.abs(dot3(axisOf(p, 2), up));
  return height(tilted) > 0.995 && height(tilted) > height(turned) ? turned : tilted;
}

class Controls {
  constructor(app, element) {
    this.app = app;
    this.pointers = new Map();
    this.action = null;
    element.addEventListener('pointerdown', (event) => this.down(event, element));
    element.addEventListener('pointermove', (event) => this.move(event));
    for (const end of ['pointerup', 'pointercancel']) element.addEventListener(end, (event) => this.up(event));
    element.addEventListener('pointerleave', () => { app.pointer = null; if (app.choosing.on) app.choosing.hover(null); app.redrawOverlay(); });
    element.addEventListener('wheel', (event) => this.wheel(event), {passive: false});
    element.addEventListener('contextmenu', (event) => event.preventDefault());
    element.addEventListener('dblclick', () => { if (!app.choosing.on) app.home(); });
  }

  // The projector whose handle lies under a place on the screen.
  handleAt(at) {
    const {app} = this;
    if (!app.frusta) return null;
    return app.projectors.find((p) => {
      const handle = handleOf(app, p).at;
      return Math.hypot(handle[0] - at[0], handle[1] - at[1]) < HANDLE + 9;
    }) || null;
  }

  chooseAction(event, at) {
    const {app} = this, aside = event.button === 2 || event.button === 1 || event.shiftKey;
    const grabbed = app.show.armed && app.mode !== 'projector' ? null : this.handleAt(at);
    if (grabbed) {
      app.select(grabbed);
      return aside ? 'aim' : 'projector';
    }
    if (app.mode === 'brush' && !aside && !event.altKey) return 'brush';
    if (app.mode === 'nudge' && !aside) return 'nudge';
    if (app.mode === 'projector' && app.projector) return aside ? 'aim' : 'projector';
    return aside ? 'pan' : 'orbit';
  }

  down(event, element) {
    const at = [event.clientX, event.clientY];
    element.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, at);
    this.clicked = this.pointers.size === 1 && event.button === 0 ? at : null;
    if (this.pointers.size === 1) this.action = this.chooseAction(event, at);
    else this.action = this.action === 'projector' || this.action === 'aim' ? 'pinch-projector' : 'pinch';
    if (this.action === 'brush') this.app.stroke(at, null);
    this.app.pull = this.action === 'nudge' ? [at, at] : null;
    this.app.blurPanel();
    event.preventDefault();
  }

  move(event) {
    const at = [event.clientX, event.clientY], before = this.pointers.get(event.pointerId);
    this.app.pointer = at;
    if (!before) {
      if (this.app.mode === 'brush') this.app.redrawOverlay();
      if (this.app.choosing.on) this.app.choosing.hover(this.app.choosing.pointUnder(at));
      return;
    }
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    this.pointers.set(event.pointerId, at);
    const dx = at[0] - before[0], dy = at[1] - before[1];
    if (this.clicked && Math.hypot(at[0] - this.clicked[0], at[1] - this.clicked[1]) > CLICK) this.clicked = null;
    if (this.clicked && this.app.choosing.on) return; // not yet a drag
    if (this.action.startsWith('pinch')) {
      if (others.length) this.pinch(before, at, others[0]);
    } else if (this.action === 'brush') this.app.stroke(at, before);
    else if (this.action === 'nudge') this.app.pull = [this.app.pull[0], at], this.app.redrawOverlay();
    else this.drag(this.action, dx, dy);
  }

  drag(action, dx, dy) {
    const {app} = this;
    if (action === 'orbit') app.turn(dx * TURN, dy * TURN);
    if (action === 'pan') app.pan(dx, dy);
    if (action === 'projector')
      app.setProjectorPose(orbit(app.projector.device.pose, app.target, app.up, dx * TURN, dy * TURN));
    if (action === 'aim') {
      const {pose} = app.projector.device, eye = positionOf(pose), slow = TURN / 4;
      const turned = turnPose(pose, axisOf(app.pose, 1), dx * slow, eye);
      app.setProjectorPose(turnPose(turned, axisOf(app.pose, 0), -dy * slow, eye));
    }
  }

  pinch(before, at, other) {
    const {app} = this, distance = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
    const factor = distance(before) / Math.max(distance(at), 1);
    if (this.action === 'pinch-projector') return app.moveProjectorAway(factor);
    app.dolly(factor);
    app.pan((at[0] - before[0]) / 2, (at[1] - before[1]) / 2);
  }

  up(event) {
    this.pointers.delete(event.pointerId);
    if (this.action === 'nudge' && event.type === 'pointerup') this.app.endPull();
    this.app.pull = null;
    const {choosing} = this.app;
    if (this.clicked && choosing.on && event.type === 'pointerup') attempt(() => choosing.choose(choosing.pointUnder(this.clicked), event))();
    if (this.pointers.size === 0) this.action = null;
    else if (this.action && this.action.startsWith('pinch')) this.action = this.action === 'pinch' ? 'orbit' : 'projector';
  }

  wheel(event) {
    const {app} = this, unit = event.deltaMode === 1 ? 16 : 1, factor = Math.exp(clamp(event.deltaY * unit, -200, 200) * 0.0012);
    event.preventDefault();
    if (app.mode === 'projector' && app.projector) {
      if (event.altKey) app.zoomProjector(1 / factor); else app.moveProjectorAway(factor);
    } else app.dolly(factor);
  }
}
