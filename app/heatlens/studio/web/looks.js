// The sheet of looks: their stills, four at a time; a tap takes one.

export class Looks {
  constructor(sheet, link) {
    this._sheet = sheet;
    this._link = link;
  }

  show({ looks = [], lens }) {
    const tiles = looks.map((look) => this._tile(look, lens));
    const isHand = this._link.role === "hand";
    const add = Object.assign(document.createElement("button"), { className: "tile add" });
    add.textContent = "Keep this look";
    add.onclick = () => this._link.do("Keep this look");
    const grid = Object.assign(document.createElement("div"), { className: "tiles" });
    grid.append(...tiles, ...(isHand ? [add] : []));
    const words = document.createElement("p");
    words.textContent = "A tap takes the lens of a look.";
    this._sheet.replaceChildren(grid, ...(looks.length && isHand ? [words, this._back()] : []));
  }

  _tile([name, fStop, focal, focus, still], lens) {
    const tile = Object.assign(document.createElement("button"), { className: "tile" });
    const words = document.createElement("span");
    words.textContent = `${name}   ${Number(focal.toPrecision(4))} mm  f/${Number(fStop.toPrecision(3))}`;
    if (still) {
      const image = Object.assign(new Image(), { alt: `Look ${name}` });
      image.src = `data:image/jpeg;base64,${still}`;
      tile.append(image);
    }
    tile.append(words);
    const isTaken = lens && lens.f_stop === fStop && lens.focal_length_mm === focal && lens.focus_distance_m === focus;
    tile.classList.toggle("taken", Boolean(isTaken));
    tile.disabled = this._link.role !== "hand";
    tile.onclick = () => this._link.do("TakeLook", { name });
    return tile;
  }

  _back() {
    const row = Object.assign(document.createElement("div"), { className: "row" });
    const back = document.createElement("button");
    back.textContent = "Back to the lens before";
    back.onclick = () => this._link.do("Back to the lens before");
    row.append(back);
    return row;
  }
}
