// The keys of the page: those that heatlens has for its commands, from its table of commands.

export const COMMANDS = {}; // the name of a command by its key, such as "Ctrl+Z"

/** Learn the keys of the table of commands, [name, key, sheet] each; sheet null: none here. */
export function learnKeys(table) {
  for (const key of Object.keys(COMMANDS)) delete COMMANDS[key];
  for (const [name, key, sheet] of table) if (key && sheet !== null) COMMANDS[key] = name;
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
