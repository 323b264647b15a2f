// Writes syntaxes/tweeze.tmLanguage.json from ../words.json.
import { readFileSync, writeFileSync } from "node:fs";
import { grammarOf } from "./template.mjs";

const wordsFile = new URL("../../words.json", import.meta.url);
export const grammarFile = new URL("../syntaxes/tweeze.tmLanguage.json", import.meta.url);

/** The text of the grammar file. */
export function grammarText() {
  const words = JSON.parse(readFileSync(wordsFile, "utf8"));
  return `${JSON.stringify(grammarOf(words), null, 2)}\n`;
}

if (process.argv[1] === import.meta.filename) writeFileSync(grammarFile, grammarText());
