// The sheet with all that is not needed every second: the view, guides, keys, and who is here.

const FRAMES = [6, 12, 18, 24, 36, 48];

export class More {
  constructor(sheet, link, page) {
    this._link = link;
    this._buttons = new Map();
    this._page = page;
    this._ofCommands = document.createElement("div");
    sheet.append(this._ofCommands);
    this._exposure = this._stepped("Darker", "Brighter", () => link.do("Reset exposure and gamma"));
    this._frames = this._stepped(() => page.setPull(-1), () => page.setPull(1));
    sheet.append(heading("Exposure of the picture"), this._exposure.row);
    sheet.append(heading("A pull to a flag takes"), this._frames.row);
    this._numbers = document.createElement("p");
    this._color = document.createElement("p");
    sheet.append(heading("This page"), this._ownRow(), this._numbers, this._color);
  }

  /** Offer the commands of the table, [name, key, sheet] each, under the headings of their sheets. */
  offer(table) {
    this._buttons.clear();
    this._ofCommands.replaceChildren();
    for (const title of new Set(table.map(([, , sheet]) => sheet).filter(Boolean))) {
      const row = Object.assign(document.createElement("div"), { className: "row hand" });
      this._fill(row, table.filter(([, , sheet]) => sheet === title).map(([name]) => name));
      this._ofCommands.append(heading(title), row);
    }
  }

  _fill(row, names) {
    for (const name of names) {
      const button = document.createElement("button");
      button.textContent = name;
      button.onclick = () => this._link.do(name);
      this._buttons.set(name, button);
      row.append(button);
    }
  }

  _stepped(less, more, reset = null) {
    const row = Object.assign(document.createElement("div"), { className: "row hand" });
    const words = document.createElement("output");
    const act = (what) => () => (typeof what === "string" ? this._link.do(what) : what());
    const [minus, plus] = [["−", less], ["+", more]].map(([sign, what]) =>
      Object.assign(document.createElement("button"), { textContent: sign, onclick: act(what) }));
    row.append(minus, words, plus);
    if (reset) row.append(Object.assign(document.createElement("button"), { textContent: "0", onclick: reset }));
    return { row, words };
  }

  _ownRow() {
    const row = Object.assign(document.createElement("div"), { className: "row" });
    for (const [words, act] of [
      ["Picture alone", () => this._page.setClean(true)],
      ["Wheel on the other side", () => this._page.swapSides()],
      ["Full screen", () => this._page.fillScreen()],
      ["Fit", () => this._page.fit()],
    ]) {
      row.append(Object.assign(document.createElement("button"), { textContent: words, onclick: act }));
    }
    return row;
  }

  show({ commands = {}, view, lens, size_px: size, blur, you }, pullFrames) {
    for (const [name, button] of this._buttons) {
      const [isOn, barred] = commands[name] || [null, "Not now"];
      button.disabled = Boolean(barred);
      button.title = barred;
      if (isOn !== null) button.setAttribute("aria-pressed", String(isOn));
    }
    if (!view) return;
    this._exposure.words.textContent = `${view.exposure_stops > 0 ? "+" : ""}${view.exposure_stops} stops`;
    this._frames.words.textContent = `${pullFrames} frames`;
    const quality = blur ? `${blur.quality || "film"} quality` : "";
    this._numbers.textContent = [
      size ? `${size[0]} × ${size[1]}` : "", lens ? `sensor ${lens.sensor_width_mm} mm` : "",
      quality, you || this._link.name,
    ].filter(Boolean).join("  ·  ");
    this._color.textContent = colorWords(view);
  }
}

/** Step through the lengths of a pull that are offered. */
export function nextFrames(now, by) {
  const at = FRAMES.indexOf(now);
  return FRAMES[Math.min(Math.max(at + by, 0), FRAMES.length - 1)];
}

function heading(words) {
  return Object.assign(document.createElement("h2"), { textContent: words });
}

/** Say whether a browser shows the colours of the window. */
function colorWords({ display, view }) {
  const name = display || "sRGB";
  const isUsual = /srgb|rec\.?1886|rec\.?709/i.test(name);
  const seen = `Colours: ${name}${view ? `, ${view}` : ""}.`;
  return isUsual ? seen : `${seen} A browser takes every picture for sRGB, so that they differ here.`;
}
