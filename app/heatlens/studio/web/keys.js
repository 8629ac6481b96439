// The keys of the window, as far as they make sense here; tests hold them against its menus.

export const COMMANDS = {
  "[": "Focus nearer",
  "]": "Focus farther",
  "Shift+[": "Open 1/3 stop",
  "Shift+]": "Close 1/3 stop",
  "Ctrl+Z": "Undo",
  "Ctrl+Shift+Z": "Redo",
  "Shift+L": "Keep this look",
  "Backspace": "Back to the lens before",
  "Q": "Next quality",
  "B": "Next bokeh",
  "Space": "Play or stop",
  "Shift+Space": "Play backwards",
  "Right": "Next frame",
  "Left": "Previous frame",
  "Home": "First frame",
  "End": "Last frame",
  "Down": "Next key",
  "Up": "Previous key",
  "I": "Set in point",
  "O": "Set out point",
  "Shift+I": "Clear in and out",
  "K": "Set key",
  "Delete": "Delete keys",
  "M": "Set mark here",
  "Shift+R": "Record a pull",
  "H": "Hold the focus from here",
  "A": "Auto key",
  "D": "Depth of field",
  "Ctrl+Up": "Brighter",
  "Ctrl+Down": "Darker",
  "U": "Metres or feet",
  "Shift+P": "Focus peaking",
};

/** Give the overlays, [name, key] each, the keys that the window has for them. */
export function learnKeys(overlays) {
  for (const [name, key] of overlays) if (key) COMMANDS[key] = name;
}

const CODES = {
  BracketLeft: "[", BracketRight: "]", ArrowRight: "Right", ArrowLeft: "Left", ArrowUp: "Up",
  ArrowDown: "Down", Equal: "+", Minus: "-", NumpadAdd: "+", NumpadSubtract: "-",
};

/** Return a key as the menus of the window write it: "Ctrl+Shift+Z". */
export function chord(event) {
  const key = CODES[event.code] || event.code.replace(/^(Key|Digit)/, "");
  const held = [[event.ctrlKey || event.metaKey, "Ctrl"], [event.shiftKey, "Shift"]];
  return [...held.filter(([isHeld]) => isHeld).map(([, name]) => name), key].join("+");
}
