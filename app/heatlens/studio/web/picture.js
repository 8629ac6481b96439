// The picture: drawn as large as there is room, zoomed and moved by fingers, focused by a tap.

const ZOOM_MOST = 16;
const TAP_PX = 10;
const NEAREST_FROM = 4; // screen pixels for one of the picture, from which pixels are squares
const SURROUND = "#0f0f10";

export class Picture {
  /** `touched(x, y)` is called with a pixel of the picture; `sized(width)` with pixels across. */
  constructor(canvas, guides, touched, sized) {
    this._canvas = canvas;
    this._guides = guides;
    this._touched = touched;
    this._sized = sized;
    this._bitmap = null;
    this._isWhole = false;
    this._shape = [16, 9, 1];
    this._shapes = null;
    this._room = [0, 0, 1, 1];
    this._fingers = new Map();
    this._isPinched = false;
    this._frame = 0;
    this.isEnabled = true;
    this.fit();
    canvas.addEventListener("pointerdown", (event) => this._press(event));
    canvas.addEventListener("pointermove", (event) => this._move(event));
    canvas.addEventListener("pointerup", (event) => this._release(event));
    canvas.addEventListener("pointercancel", (event) => this._forget(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** Show a picture; `isWhole`: it is at rest and without loss, no better one follows. */
  show(bitmap, isWhole) {
    this._bitmap?.close();
    this._bitmap = bitmap;
    this._isWhole = isWhole;
    this.redraw();
  }

  /** Take the size of the picture, [width, height, pixel aspect], and the guides over it. */
  describe(shape, guides) {
    if (shape) this._shape = shape;
    if (guides !== undefined) this._shapes = guides;
    this.redraw();
  }

  /** Show the picture within [x, y, width, height] of the screen. */
  place(room) {
    this._room = room;
    this.redraw();
  }

  fit() {
    [this._zoom, this._shiftX, this._shiftY] = [1, 0, 0];
    this.redraw();
  }

  /** Zoom by a factor; the point under `at` stays, the middle without one. */
  zoomBy(factor, at = this._middle) {
    const before = this._zoom;
    const ownSize = before / (this._scale * devicePixelRatio);
    this._zoom = Math.min(Math.max(before * factor, Math.min(1, ownSize)), ZOOM_MOST);
    const by = this._zoom / before;
    const [x, y] = this._middle;
    this._shiftX = (at[0] - x) * (1 - by) + this._shiftX * by;
    this._shiftY = (at[1] - y) * (1 - by) + this._shiftY * by;
    this._keepNear();
    this.redraw();
  }

  oneToOne() {
    this.zoomBy(1 / (this._scale * devicePixelRatio));
  }

  redraw() {
    this._frame ||= requestAnimationFrame(() => {
      this._frame = 0;
      this._draw();
    });
  }

  // Places

  get _middle() {
    const [x, y, width, height] = this._room;
    return [x + width / 2, y + height / 2];
  }

  /** Screen units for one line of the picture. */
  get _scale() {
    const [width, height, aspect] = this._shape;
    return this._zoom * Math.min(this._room[2] / (width * aspect), this._room[3] / height);
  }

  /** The corner and size of the picture on the screen. */
  get _box() {
    const [width, height, aspect] = this._shape;
    const [x, y] = this._middle;
    const size = [width * aspect * this._scale, height * this._scale];
    return [x + this._shiftX - size[0] / 2, y + this._shiftY - size[1] / 2, ...size];
  }

  _pixelAt(x, y) {
    const [x0, y0, width, height] = this._box;
    return [(x - x0) / width * this._shape[0], (y - y0) / height * this._shape[1]].map(Math.floor);
  }

  _keepNear() {
    const [, , width, height] = this._box;
    const most = [Math.max(width - this._room[2], 0) / 2, Math.max(height - this._room[3], 0) / 2];
    this._shiftX = Math.min(Math.max(this._shiftX, -most[0]), most[0]);
    this._shiftY = Math.min(Math.max(this._shiftY, -most[1]), most[1]);
  }

  // Fingers: one focuses, two zoom and move; with a mouse the other buttons move

  _press(event) {
    this._canvas.setPointerCapture(event.pointerId);
    const finger = { x: event.clientX, y: event.clientY, from: [event.clientX, event.clientY] };
    finger.moves = event.button > 0;
    this._fingers.set(event.pointerId, finger);
    this._isPinched = this._fingers.size > 1 || (this._isPinched && this._fingers.size > 0);
    if (event.pointerType === "mouse" && !finger.moves) this._focus(event);
  }

  _move(event) {
    const finger = this._fingers.get(event.pointerId);
    if (!finger) return;
    const before = this._spread();
    const [dx, dy] = [event.clientX - finger.x, event.clientY - finger.y];
    [finger.x, finger.y] = [event.clientX, event.clientY];
    if (this._fingers.size === 1 && !this._isPinched && !finger.moves) {
      finger.isDrag ||= Math.hypot(finger.x - finger.from[0], finger.y - finger.from[1]) > TAP_PX;
      if (finger.isDrag) this._focus(event);
      return;
    }
    const count = this._fingers.size;
    this._shiftX += dx / count;
    this._shiftY += dy / count;
    const now = this._spread();
    if (before && now) this.zoomBy(now.apart / before.apart, now.middle);
    this._keepNear();
    this.redraw();
  }

  _release(event) {
    const finger = this._fingers.get(event.pointerId);
    const isTap = finger && !finger.isDrag && !finger.moves && event.pointerType !== "mouse";
    if (isTap && !this._isPinched) this._focus(event);
    this._forget(event);
  }

  _forget(event) {
    this._fingers.delete(event.pointerId);
    if (!this._fingers.size) this._isPinched = false;
  }

  /** Return how far two fingers are apart, and the point between them. */
  _spread() {
    const [a, b] = this._fingers.values();
    if (!b) return null;
    return {
      apart: Math.max(Math.hypot(a.x - b.x, a.y - b.y), 10),
      middle: [(a.x + b.x) / 2, (a.y + b.y) / 2],
    };
  }

  _focus(event) {
    const [x, y] = this._pixelAt(event.clientX, event.clientY);
    const isInside = x >= 0 && y >= 0 && x < this._shape[0] && y < this._shape[1];
    if (isInside && this.isEnabled) this._touched(x, y, event);
  }

  // Drawing

  _draw() {
    const [x, y, width, height] = this._box;
    const draw = sized(this._canvas);
    draw.fillStyle = SURROUND;
    draw.fillRect(0, 0, innerWidth, innerHeight);
    if (this._bitmap) {
      const ratio = devicePixelRatio;
      const whole = [x, y, width, height].map((value) => Math.round(value * ratio) / ratio);
      draw.imageSmoothingEnabled = width * ratio / this._bitmap.width < NEAREST_FROM;
      draw.imageSmoothingQuality = "high";
      draw.drawImage(this._bitmap, ...whole);
    }
    this._canvas.ariaBusy = String(!this._isWhole);
    this._drawGuides(x, y, this._scale);
    this._sized(width * devicePixelRatio);
  }

  _drawGuides(x, y, scale) {
    const draw = sized(this._guides);
    draw.clearRect(0, 0, innerWidth, innerHeight);
    if (!this._shapes) return;
    const at = ([x0, y0, x1, y1]) => [x + x0 * scale, y + y0 * scale, (x1 - x0) * scale, (y1 - y0) * scale];
    draw.fillStyle = `rgb(0 0 0 / ${this._shapes.opacity})`;
    draw.strokeStyle = "rgb(255 255 255 / 0.55)";
    for (const rect of this._shapes.shades) draw.fillRect(...at(rect));
    for (const rect of this._shapes.frames) draw.strokeRect(...at(rect));
    draw.beginPath();
    for (const line of this._shapes.lines) {
      const [x0, y0, dx, dy] = at(line);
      draw.moveTo(x0, y0);
      draw.lineTo(x0 + dx, y0 + dy);
    }
    draw.stroke();
  }
}

/** Return a context whose units are those of the page, on a canvas of the screen's own pixels. */
export function sized(canvas) {
  const size = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.round(side * devicePixelRatio));
  if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
  const draw = canvas.getContext("2d");
  draw.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
  return draw;
}
