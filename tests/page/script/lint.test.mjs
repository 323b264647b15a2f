import js from "@eslint/js";
import { Linter } from "eslint";
import globals from "globals";
import assert from "node:assert/strict";
import test from "node:test";
import { parts } from "./script.mjs";

const rules = {
  ...js.configs.recommended.rules,
  eqeqeq: "error",
  "no-shadow": "error",
  "no-unused-vars": ["error", { argsIgnorePattern: "^_" }],
  "no-var": "error",
  "prefer-const": "error",
};

const languageOptions = { ecmaVersion: 2023, sourceType: "script", globals: globals.browser };

/** Maps a line of the concatenated parts to its file and line. */
function place(line) {
  let before = 0;
  for (const { name, text } of parts) {
    const lines = text.split("\n").length - 1;
    if (line <= before + lines) return `${name}:${line - before}`;
    before += lines;
  }
  return `line ${line}`;
}

test("the parts together are free of lint", () => {
  assert.equal(parts.length, 11);
  const found = new Linter().verify(parts.map(({ text }) => text).join(""), { rules, languageOptions });
  assert.deepEqual(found.map(({ line, message, ruleId }) => `${place(line)} ${message} (${ruleId})`), []);
});

test("lint is found at its place", () => {
  const [first, ...others] = parts;
  const text = [first.text, "const nobody = missing;\n", ...others.map((part) => part.text)].join("");
  const found = new Linter().verify(text, { rules, languageOptions });
  assert.deepEqual(found.map(({ ruleId }) => ruleId).sort(), ["no-undef", "no-unused-vars"]);
});
