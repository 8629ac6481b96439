// Ties the parts of the page together: what the state shows, and what a touch asks for.

import { metres, toJson, words } from "./distances.js";
import { COMMANDS, chord, learnKeys } from "./keys.js";
import { Link } from "./link.js";
import { Looks } from "./looks.js";
import { More, nextFrames } from "./more.js";
import { Picture } from "./picture.js";
import { Transport } from "./transport.js";
import { Wheel } from "./wheel.js";

const SEND_MS = 16; // between two messages of a drag
const NOTE_MS = 4000;
const BEHIND_MS = 600; // without a new picture, until one of another lens is dimmed
const STOP_PX = 26; // of a drag, for a third of a stop
const $ = (id) => document.getElementById(id);
const body = document.body;
let pullFrames = 18;
let noteTimer = 0;
let behindTimer = 0;
let shownNumber = 0; // of the lens and the frame that the picture shows

/** Send the newest value only, as often as the line should carry. */
function paced(send) {
  let [timer, due] = [0, null];
  return (...values) => {
    due = values;
    timer ||= setTimeout(() => {
      timer = 0;
      send(...due);
    }, SEND_MS);
  };
}

const shown = (bitmap, { whole, lens_number: number }) => {
  picture.show(bitmap, whole);
  shownNumber = number;
  watchPicture();
};
const link = new Link({ hello, state, problem, picture: shown, line });
const focus = paced((distance) => link.do("Focus", { distance_m: toJson(distance) }));
const focusAt = paced((x, y) => link.do("FocusAt", { x_px: x, y_px: y }));
const wheel = new Wheel($("wheel"), focus, pull);
const picture = new Picture($("picture"), $("guides"), focusAt, (width) => link.resize(width));
const transport = new Transport(
  { scrub: $("scrub"), play: $("play"), back: $("back"), forward: $("forward"), frame: $("frame") },
  link,
);
const looks = new Looks($("looks"), link);
const page = { setClean, swapSides, fillScreen, fit: () => picture.fit(), setPull };
const more = new More($("more"), link, page);

// What is heard

function hello({ role }) {
  body.classList.toggle("look", role !== "hand");
  wheel.isEnabled = picture.isEnabled = role === "hand";
}

function line(isOpen, why) {
  body.classList.toggle("waiting", !isOpen);
  $("dot").title = isOpen ? "Connected" : "Waiting for heatlens";
  if (isOpen || why) whyCut = why;
  $("cut").textContent = `Line lost, trying again. ${whyCut}`.trim();
  $("cut").hidden = isOpen;
}

let whyCut = ""; // why heatlens has ended, while the line is cut

/** Dim a picture that is not that of the numbers, unless others follow quickly. */
function watchPicture() {
  clearTimeout(behindTimer);
  const isBehind = shownNumber !== link.state.lens_number;
  if (isBehind) behindTimer = setTimeout(() => body.classList.add("behind"), BEHIND_MS);
  else body.classList.remove("behind");
}

function problem(sentence) {
  note(sentence.replace(/^message: */, ""), true);
}

function state(changed) {
  const now = link.state;
  if ("lens_number" in changed) watchPicture();
  if ("shape" in changed || "guides" in changed) picture.describe(now.shape, now.guides);
  if ("table" in changed) {
    learnKeys(now.table, OWN);
    more.offer(now.table);
  }
  if ("message" in changed && now.message) note(now.message, now.is_problem);
  if ("looks" in changed || "lens" in changed) looks.show(now);
  wheel.show(now);
  transport.show(now);
  more.show(now, pullFrames);
  showWords(now);
  showRecording(now);
  place();
}

function showWords({ lens, near_m: near, far_m: far, view, title, source, hand, opening, scale, offset_m: offset = 0 }) {
  $("title").textContent = opening ? `Opening ${opening}` : title || source || "heatlens";
  const isOther = hand && hand !== link.name;
  $("holder").textContent = isOther ? `${hand} moves the lens` : "";
  $("f-stop").textContent = lens ? `f/${Number(lens.f_stop.toPrecision(2))}` : "f/–";
  if (!lens || !scale) return;
  const told = (distance) => words(metres(distance) + offset, view.unit);
  const parts = [
    ["span", `${Number(lens.focal_length_mm.toPrecision(4))} mm  `],
    ["span", `f/${Number(lens.f_stop.toPrecision(3))}  `],
    ["b", told(lens.focus_distance_m)],
    ["i", `  ${told(near)} – ${told(far)}`],
  ];
  $("numbers").replaceChildren(...parts.map(([tag, text]) =>
    Object.assign(document.createElement(tag), { textContent: text })));
}

function showRecording({ recording, beats_left: beats, recorded_keys: keys }) {
  const isOn = ["armed", "counting", "recording"].includes(recording);
  body.classList.toggle("recording", isOn);
  $("beats").textContent = beats || "";
  $("take").hidden = recording !== "recorded" || link.role !== "hand" || keptTake === keys;
  if (recording !== "recorded") keptTake = null;
  $("take-words").textContent = `The pull has become ${keys} ${keys === 1 ? "key" : "keys"}`;
}
let keptTake = null;

function note(sentence, isProblem = false) {
  clearTimeout(noteTimer);
  $("note").textContent = sentence;
  $("note").className = isProblem ? "shown problem" : "shown";
  noteTimer = setTimeout(() => { $("note").className = ""; }, NOTE_MS);
}

// What is asked for

/** Pull to a mark over the frames that are set; a still goes there at once. */
function pull(name) {
  const { first, last, marks } = link.state;
  if (first < last) link.do("Pull", { mark: name, frames: pullFrames });
  else link.do("Focus", { distance_m: marks.find((mark) => mark.name === name).distance_m });
}

function setPull(by) {
  pullFrames = nextFrames(pullFrames, by);
  more.show(link.state, pullFrames);
}

function record() {
  link.do("Record a pull");
  if (link.state.recording === "off" || link.state.recording === "recorded") link.do("Play or stop");
}

function holdPinhole(isHeld) {
  link.change("view", { depth_of_field: !isHeld });
  $("eye").setAttribute("aria-pressed", String(isHeld));
}

function setClean(isClean) {
  body.classList.toggle("clean", isClean);
  closeSheets();
  place();
}

function swapSides() {
  body.classList.toggle("left");
  localStorage.setItem("left", body.classList.contains("left") ? "1" : "");
  place();
}

function fillScreen() {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen?.().catch(() => note("This browser has no full screen.", true));
}

function closeSheets() {
  for (const name of ["looks", "more"]) toggle(name, false);
}

function toggle(name, isOpen = $(name).hidden) {
  $(name).hidden = !isOpen;
  $(`show-${name}`).setAttribute("aria-expanded", String(isOpen));
}

/** Give the picture the room that wheel and bars leave. */
function place() {
  const isClean = body.classList.contains("clean");
  const box = (id) => $(id).getBoundingClientRect();
  let [x, y, right, bottom] = [0, 0, innerWidth, innerHeight];
  if (!isClean) {
    const [strip, bar, top] = [box("wheel"), box("bar"), box("top")];
    const isUpright = strip.width > strip.height;
    if (isUpright) bottom = strip.top;
    else [x, right] = strip.left > innerWidth / 2 ? [0, strip.left] : [strip.right, right];
    const isRoomy = innerHeight > 480;
    if (isRoomy && !isUpright) bottom = bar.top;
    if (isRoomy) y = top.bottom;
  }
  picture.place([x, y, right - x, bottom - y]);
}

// Controls

$("record").onclick = record;
$("open").onclick = () => link.do("Open 1/3 stop");
$("close").onclick = () => link.do("Close 1/3 stop");
$("show-looks").onclick = () => { toggle("more", false); toggle("looks"); };
$("show-more").onclick = () => { toggle("looks", false); toggle("more"); };
$("keep").onclick = () => { keptTake = link.state.recorded_keys; showRecording(link.state); };
$("drop").onclick = () => link.do("Undo");
$("leave").onclick = () => { $("leave").hidden = true; setClean(false); };
$("picture").addEventListener("pointerdown", closeSheets);
$("picture").addEventListener("pointerup", () => {
  if (!body.classList.contains("clean")) return;
  $("leave").hidden = false;
  setTimeout(() => { $("leave").hidden = true; }, NOTE_MS);
});

$("eye").addEventListener("pointerdown", (event) => {
  $("eye").setPointerCapture(event.pointerId);
  holdPinhole(true);
});
for (const end of ["pointerup", "pointercancel"]) $("eye").addEventListener(end, () => holdPinhole(false));
$("eye").addEventListener("contextmenu", (event) => event.preventDefault());

let stopFrom = null;
$("stop").addEventListener("pointerdown", (event) => { stopFrom = event.clientX; });
addEventListener("pointermove", (event) => {
  if (stopFrom === null || Math.abs(event.clientX - stopFrom) < STOP_PX) return;
  const way = Math.sign(event.clientX - stopFrom);
  stopFrom += way * STOP_PX;
  link.do(way > 0 ? "Close 1/3 stop" : "Open 1/3 stop");
});
for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => { stopFrom = null; });

$("picture").addEventListener("wheel", (event) => {
  event.preventDefault();
  const way = -Math.sign(event.deltaY || event.deltaX);
  if (event.shiftKey) link.do("NudgeFocus", { notches: way });
  else picture.zoomBy(1.2 ** way, [event.clientX, event.clientY]);
}, { passive: false });

// Keys: those of the window, and a few for what only this page has

const OWN = { // the picture of each page has its own zoom: the commands by which the window sets its
  "Fit": () => picture.fit(),
  "1:1": () => picture.oneToOne(),
  "Zoom in": () => picture.zoomBy(2),
  "Zoom out": () => picture.zoomBy(0.5),
};
const OWN_KEYS = {
  "Tab": () => setClean(!body.classList.contains("clean")),
  "Escape": () => (body.classList.contains("clean") ? setClean(false) : closeSheets()),
};

addEventListener("keydown", (event) => {
  if (event.altKey) {
    if (event.key === "Alt" && !event.repeat) holdPinhole(true);
    event.preventDefault();
    return;
  }
  const pressed = chord(event), name = COMMANDS[pressed];
  const isPressing = event.target instanceof HTMLButtonElement && ["Space", "Enter"].includes(event.code);
  if (isPressing || (!OWN_KEYS[pressed] && !name)) return;
  event.preventDefault();
  if (OWN_KEYS[pressed]) OWN_KEYS[pressed]();
  else if (OWN[name]) OWN[name]();
  else if (name === "Record a pull") record();
  else link.do(name);
});
addEventListener("keyup", (event) => { if (event.key === "Alt") holdPinhole(false); });
addEventListener("resize", place);
body.classList.toggle("left", Boolean(localStorage.getItem("left")));
place();
