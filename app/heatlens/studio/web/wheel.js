// The focus wheel: a barrel that turns under a fixed index, as a follow focus does.
//
// Equal ways are equal dioptres. What lies on the barrel is drawn at once under the finger; the
// picture comes when it comes.

import { engraved, metres, rounds, words } from "./distances.js";

const LENGTH = 2.6; // of the barrel, in lengths of the strip
const FRICTION = 0.0045; // share of the speed that is lost in a millisecond
const STOP = 0.02; // pixels in a millisecond, under which it stands
const CATCH = 0.9; // and under which a mark on its way holds it
const TAP_PX = 8;
const HELD_MS = 400; // so long after a touch the wheel shows what the hand asks for
const COLORS = {
  ground: "#161617", edge: "#000", tick: "#707074", label: "#d8d8da", columns: "#55565b",
  band: "rgb(90 200 110 / 0.22)", sharp: "#5ac86e", index: "#f2a93b", onIndex: "#181208",
  mark: "#78b2e8", onMark: "#0b1622", key: "#78b2e8", hyper: "#c8c8cd",
};

export class Wheel {
  /** `turned(distance)` is called for each new focus, `pulled(mark)` for a tap on a flag. */
  constructor(canvas, turned, pulled) {
    this._canvas = canvas;
    this._turned = turned;
    this._pulled = pulled;
    this._facts = null;
    this._dioptres = 0;
    this._speed = 0; // dioptres in a millisecond
    this._touchedAt = -Infinity;
    this._finger = null;
    this._flags = [];
    this.isEnabled = true;
    this._frame = 0;
    canvas.addEventListener("pointerdown", (event) => this._press(event));
    canvas.addEventListener("pointermove", (event) => this._drag(event));
    canvas.addEventListener("pointerup", (event) => this._release(event));
    canvas.addEventListener("pointercancel", () => { this._finger = null; });
    canvas.addEventListener("wheel", (event) => this._roll(event), { passive: false });
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  /** Show the state; while the hand turns, its own focus stays. */
  show(state) {
    const { lens, scale, marks, near_m, far_m, view } = state;
    this._facts = lens && scale ? {
      most: scale.most_dioptres,
      heights: scale.heights,
      unit: view.unit,
      marks: marks.filter((mark) => mark.distance_m != null)
        .map((mark) => ({ name: mark.name, at: 1 / metres(mark.distance_m) })),
      reach: (1 / metres(near_m) - 1 / metres(far_m)) / 2,
      hyper: state.hyperfocal_m ? 1 / state.hyperfocal_m : null,
      keyed: state.keyed_focus_m == null ? null : 1 / metres(state.keyed_focus_m),
      offset: state.offset_m || 0,
    } : null;
    const isHeld = this._finger || this._speed || performance.now() - this._touchedAt < HELD_MS;
    if (this._facts && !isHeld) this._dioptres = 1 / metres(lens.focus_distance_m);
    this.redraw();
  }

  redraw() {
    this._frame ||= requestAnimationFrame((now) => this._step(now));
  }

  /** Turn by hand to a focus in dioptres; returns false at an end of the barrel. */
  turnTo(dioptres) {
    if (!this._facts || !this.isEnabled) return false;
    const held = Math.min(Math.max(dioptres, 0), this._facts.most);
    if (held === this._dioptres) return false;
    this._buzz(this._dioptres, held);
    this._dioptres = held;
    this._touchedAt = performance.now();
    this._turned(held ? 1 / held : Infinity);
    this.redraw();
    return held === dioptres;
  }

  get distance() {
    return this._dioptres ? 1 / this._dioptres : Infinity;
  }

  _buzz(before, after) {
    const passed = this._facts.marks.some((mark) => (mark.at - before) * (mark.at - after) < 0);
    if (passed && this._finger) navigator.vibrate?.(8);
  }

  // Fingers

  get _isUpright() {
    return this._canvas.clientHeight > this._canvas.clientWidth;
  }

  get _length() {
    return Math.max(this._canvas.clientHeight, this._canvas.clientWidth);
  }

  /** Dioptres for a pixel along the strip: near lies at its lower or left end. */
  get _perPixel() {
    const way = this._facts ? this._facts.most / (LENGTH * this._length) : 0;
    return this._isUpright ? -way : way;
  }

  _along(event) {
    return this._isUpright ? event.offsetY : event.offsetX;
  }

  _press(event) {
    if (this._finger || !this._facts) return;
    this._canvas.setPointerCapture(event.pointerId);
    const at = this._along(event);
    this._speed = 0;
    this._finger = { id: event.pointerId, from: at, at, time: event.timeStamp, moved: 0, pace: 0 };
    event.preventDefault();
  }

  _drag(event) {
    const finger = this._finger;
    if (!finger || finger.id !== event.pointerId) return;
    const at = this._along(event);
    const way = at - finger.at;
    const time = Math.max(event.timeStamp - finger.time, 1);
    finger.moved = Math.max(finger.moved, Math.abs(at - finger.from));
    if (finger.moved < TAP_PX) return;
    finger.pace = 0.6 * (way / time) + 0.4 * finger.pace;
    [finger.at, finger.time] = [at, event.timeStamp];
    this.turnTo(this._dioptres + way * this._perPixel);
  }

  _release(event) {
    const finger = this._finger;
    if (!finger || finger.id !== event.pointerId) return;
    this._finger = null;
    if (finger.moved < TAP_PX) {
      this._tap(event);
    } else if (event.timeStamp - finger.time < 60) {
      this._speed = finger.pace * this._perPixel;
      this._rolledAt = performance.now();
    }
    this.redraw();
  }

  _tap(event) {
    const [x, y] = [event.offsetX, event.offsetY];
    const flag = this._flags.find(({ box: [x0, y0, x1, y1] }) =>
      x > x0 - 6 && x < x1 + 6 && y > y0 - 6 && y < y1 + 6);
    if (flag && this.isEnabled) this._pulled(flag.mark);
  }

  _roll(event) {
    event.preventDefault();
    if (this._facts) this.turnTo(this._dioptres - Math.sign(event.deltaY) * this._facts.most / 160);
  }

  /** Let it roll on; a mark holds it once it is slow. */
  _step(now) {
    this._frame = 0;
    if (this._speed && !this._finger) {
      const time = Math.min(now - this._rolledAt, 50);
      this._rolledAt = now;
      const next = this._dioptres + this._speed * time;
      const pixels = Math.abs(this._speed / this._perPixel);
      const held = pixels < CATCH && this._facts.marks.find((mark) =>
        (mark.at - this._dioptres) * (mark.at - next) <= 0 && mark.at !== this._dioptres);
      const goesOn = this.turnTo(held ? held.at : next);
      this._speed *= Math.exp(-FRICTION * time);
      if (held) navigator.vibrate?.(12);
      if (held || !goesOn || pixels < STOP) this._speed = 0;
      if (this._speed) this.redraw();
    }
    this._draw();
  }

  // Drawing

  _draw() {
    const canvas = this._canvas;
    const ratio = devicePixelRatio;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    }
    const draw = canvas.getContext("2d", { alpha: false });
    draw.setTransform(ratio, 0, 0, ratio, 0, 0);
    draw.fillStyle = COLORS.ground;
    draw.fillRect(0, 0, width, height);
    this._flags = [];
    if (!this._facts) return;
    canvas.setAttribute("aria-valuetext", words(this.distance, this._facts.unit));
    const barrel = new Barrel(draw, width, height, this._dioptres, this._perPixel);
    this._drawDepths(barrel);
    this._drawScale(barrel);
    this._drawMarks(barrel);
    this._drawIndex(barrel);
    barrel.shade();
  }

  _drawDepths(barrel) {
    const { heights, most, reach } = this._facts;
    const highest = Math.max(...heights.slice(1), 1e-9);
    const step = most / heights.length;
    const focus = this._dioptres;
    barrel.band(focus - reach, focus + reach, COLORS.band);
    heights.forEach((height, index) => {
      if (!height) return;
      const middle = (index + 0.5) * step;
      const isSharp = Math.abs(middle - focus) < reach + step / 2;
      const part = Math.min(height / highest, 1);
      barrel.column(index * step, step, part, isSharp ? COLORS.sharp : COLORS.columns);
    });
    for (const edge of [focus - reach, focus + reach]) {
      if (edge > 0 && edge < most) barrel.line(edge, 0, 1, COLORS.sharp, 1);
    }
    barrel.band(-most, 0, COLORS.edge);
    barrel.band(most, 2 * most, COLORS.edge);
  }

  _drawScale(barrel) {
    const { most, unit, offset, hyper } = this._facts;
    const taken = [];
    barrel.label(0, "∞", taken);
    for (const distance of rounds(1 / most + offset, unit)) {
      const at = 1 / (distance - offset);
      if (distance > offset && at <= most) barrel.label(at, engraved(distance, unit), taken);
    }
    if (hyper) barrel.triangle(hyper, COLORS.hyper);
  }

  _drawMarks(barrel) {
    const { marks, keyed } = this._facts;
    for (const mark of marks) {
      barrel.line(mark.at, 0, 1, COLORS.mark, 1.5);
      this._flags.push({ mark: mark.name, box: barrel.flag(mark.at, mark.name) });
    }
    if (keyed != null) barrel.line(keyed, 0, 0.6, COLORS.key, 3);
  }

  _drawIndex(barrel) {
    barrel.line(this._dioptres, 0, 1, COLORS.index, 2.5);
    barrel.plate(words(this.distance === Infinity ? Infinity : this.distance + this._facts.offset, this._facts.unit));
  }
}

/** Draws things at their dioptres on a strip that stands or lies. */
class Barrel {
  constructor(draw, width, height, focus, perPixel) {
    this.isUpright = height > width;
    this.draw = draw;
    [this.length, this.depth] = this.isUpright ? [height, width] : [width, height];
    this._focus = focus;
    this._perPixel = perPixel;
    draw.font = `${Math.round(Math.min(15, this.depth / 6.5))}px system-ui, sans-serif`;
    draw.textBaseline = "middle";
    draw.textAlign = "center";
  }

  at(dioptres) {
    return this.length / 2 + (this._focus - dioptres) / this._perPixel;
  }

  /** Fill a rectangle, given along and across the strip. */
  fill(along, across, length, depth, color) {
    this.draw.fillStyle = color;
    if (this.isUpright) this.draw.fillRect(across, along, depth, length);
    else this.draw.fillRect(along, this.depth - across - depth, length, depth);
  }

  place(along, across) {
    return this.isUpright ? [across, along] : [along, this.depth - across];
  }

  band(from, to, color) {
    const [a, b] = [this.at(from), this.at(to)].sort((x, y) => x - y);
    if (b > 0 && a < this.length) this.fill(a, 0, b - a, this.depth, color);
  }

  column(from, step, part, color) {
    const [a, b] = [this.at(from), this.at(from + step)].sort((x, y) => x - y);
    const depth = part * this.depth * 0.36;
    if (b > 0 && a < this.length) this.fill(a, this.depth - depth, b - a + 0.5, depth, color);
  }

  line(dioptres, from, to, color, width) {
    this.fill(this.at(dioptres) - width / 2, from * this.depth, width, (to - from) * this.depth, color);
  }

  label(dioptres, text, taken) {
    const along = this.at(dioptres);
    if (along < -20 || along > this.length + 20) return;
    const half = (this.isUpright ? 20 : this.draw.measureText(text).width + 14) / 2;
    if (taken.some(([a, b]) => along + half > a && along - half < b)) return;
    taken.push([along - half, along + half]);
    this.fill(along - 0.5, 0, 1, this.depth * 0.09, COLORS.label);
    this.draw.fillStyle = COLORS.label;
    this.draw.fillText(text, ...this.place(along, this.depth * 0.26));
  }

  triangle(dioptres, color) {
    const along = this.at(dioptres);
    this.draw.fillStyle = color;
    this.draw.beginPath();
    for (const [a, c] of [[-5, 0], [5, 0], [0, 8]]) this.draw.lineTo(...this.place(along + a, c));
    this.draw.fill();
  }

  /** Draw the flag of a mark, of tape, and return its box. */
  flag(dioptres, name) {
    const width = Math.min(this.draw.measureText(name).width + 14, this.depth * 0.7);
    const along = this.at(dioptres);
    const [x, y] = this.place(along, this.isUpright ? this.depth - width / 2 : this.depth - 12);
    const box = [x - width / 2, y - 11, x + width / 2, y + 11];
    this.draw.fillStyle = COLORS.mark;
    this.draw.beginPath();
    this.draw.roundRect(box[0], box[1], width, 22, 3);
    this.draw.fill();
    this.draw.fillStyle = COLORS.onMark;
    this.draw.fillText(name, x, y, width - 6);
    return box;
  }

  /** Draw the figure of the focus on the index. */
  plate(text) {
    this.draw.save();
    this.draw.font = `600 ${Math.round(Math.min(17, this.depth / 5.5))}px system-ui, sans-serif`;
    const width = this.draw.measureText(text).width + 16;
    const across = this.isUpright ? Math.max(width / 2, this.depth * 0.36) : this.depth * 0.26;
    const [x, y] = this.place(this.length / 2, across);
    this.draw.fillStyle = COLORS.index;
    this.draw.beginPath();
    this.draw.roundRect(x - width / 2, y - 14, width, 28, 5);
    this.draw.fill();
    this.draw.fillStyle = COLORS.onIndex;
    this.draw.fillText(text, x, y + 1);
    this.draw.restore();
  }

  /** Let the ends fall away, as on a round barrel. */
  shade() {
    const [x, y] = this.isUpright ? [0, this.length] : [this.length, 0];
    const shade = this.draw.createLinearGradient(0, 0, x, y);
    for (const [at, alpha] of [[0, 0.85], [0.22, 0], [0.78, 0], [1, 0.85]]) {
      shade.addColorStop(at, `rgb(0 0 0 / ${alpha})`);
    }
    this.fill(0, 0, this.length, this.depth, shade);
  }
}
