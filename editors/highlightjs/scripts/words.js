// Writes words.js from ../words.json.
import { readFileSync, writeFileSync } from "node:fs";

export const wordsFile = new URL("../words.js", import.meta.url);

/** The text of words.js. */
export function wordsText() {
  const words = readFileSync(new URL("../../words.json", import.meta.url), "utf8");
  return `// Written by scripts/words.js from ../words.json.\nexport default ${words.trimEnd()};\n`;
}

if (process.argv[1] === import.meta.filename) writeFileSync(wordsFile, wordsText());
