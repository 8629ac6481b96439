// The keys of the page: those that heatlens has for its commands, from its table of commands.

export const COMMANDS = {}; // the name of a command by its key, such as "Ctrl+Z"

/**
 * Learn the keys of the table of commands, [name, key, sheet] each; sheet null: none here, unless
 * the page does the same to itself, `own` by name of the command.
 */
export function learnKeys(table, own = {}) {
  for (const key of Object.keys(COMMANDS)) delete COMMANDS[key];
  for (const [name, key, sheet] of table) if (key && (sheet !== null || own[name])) COMMANDS[key] = name;
}

const CODES = {
  BracketLeft: "[", BracketRight: "]", ArrowRight: "Right", ArrowLeft: "Left", ArrowUp: "Up",
  ArrowDown: "Down", Equal: "+", Minus: "-", NumpadAdd: "+", NumpadSubtract: "-",
};

/** Return a key as the menus of the window write it: "Ctrl+Shift+Z"; + may be typed with Shift. */
export function chord(event) {
  const key = CODES[event.code] || event.code.replace(/^(Key|Digit)/, "");
  const held = [[event.ctrlKey || event.metaKey, "Ctrl"], [event.shiftKey && key !== "+", "Shift"]];
  return [...held.filter(([isHeld]) => isHeld).map(([, name]) => name), key].join("+");
}
