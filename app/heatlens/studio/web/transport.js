// Time: play, step, scrub over the frames, with the keys of the focus as ticks.

import { sized } from "./picture.js";

const EDGE = 10;

export class Transport {
  constructor(parts, link) {
    this._parts = parts;
    this._link = link;
    this._state = {};
    this._finger = null;
    const { scrub, play, back, forward } = parts;
    play.onclick = () => link.do("Play or stop");
    back.onclick = () => link.do("Previous frame");
    forward.onclick = () => link.do("Next frame");
    scrub.addEventListener("pointerdown", (event) => {
      scrub.setPointerCapture(event.pointerId);
      this._finger = event.pointerId;
      this._scrub(event);
    });
    scrub.addEventListener("pointermove", (event) => {
      if (event.pointerId === this._finger) this._scrub(event);
    });
    for (const end of ["pointerup", "pointercancel"]) {
      scrub.addEventListener(end, () => { this._finger = null; this._draw(); });
    }
    new ResizeObserver(() => this._draw()).observe(scrub);
  }

  show(state) {
    this._state = state;
    const isStill = !(state.first < state.last);
    document.body.classList.toggle("still", isStill);
    document.body.classList.toggle("playing", Boolean(state.direction));
    if (this._finger === null) this._frame = state.frame;
    this._parts.frame.textContent = this._frame ?? "";
    this._parts.frame.title = state.timecode || "";
    for (const name of ["play", "back", "forward"]) this._parts[name].disabled = this._link.role !== "hand";
    this._draw();
  }

  _scrub(event) {
    const { first, last } = this._state;
    const part = (event.offsetX - EDGE) / (this._parts.scrub.clientWidth - 2 * EDGE);
    const frame = Math.round(first + Math.min(Math.max(part, 0), 1) * (last - first));
    if (frame === this._frame || this._link.role !== "hand") return;
    this._frame = frame;
    this._parts.frame.textContent = frame;
    this._link.do("Go", { frame });
    this._draw();
  }

  _draw() {
    const { first, last, focus_keys: keys = [], recording } = this._state;
    const { scrub } = this._parts;
    const draw = sized(scrub);
    const [width, height] = [scrub.clientWidth, scrub.clientHeight];
    draw.clearRect(0, 0, width, height);
    if (!(first < last)) return;
    const at = (frame) => EDGE + (frame - first) / (last - first) * (width - 2 * EDGE);
    draw.fillStyle = recording === "recording" ? "#f05c52" : "#4a4a4d";
    draw.fillRect(EDGE, height / 2 - 2, width - 2 * EDGE, 4);
    draw.fillStyle = "#78b2e8";
    for (const key of keys) {
      draw.save();
      draw.translate(at(key), height / 2);
      draw.rotate(Math.PI / 4);
      draw.fillRect(-4, -4, 8, 8);
      draw.restore();
    }
    draw.fillStyle = "#f2a93b";
    draw.beginPath();
    draw.roundRect(at(this._frame) - 3, height / 2 - 13, 6, 26, 3);
    draw.fill();
  }
}
