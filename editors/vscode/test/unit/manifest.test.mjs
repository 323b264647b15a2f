// Tests of package.json and the language configuration.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import test from "node:test";
import { inEditor } from "./stand-in.mjs";

const root = new URL("../../", import.meta.url);
const read = (name) => JSON.parse(readFileSync(new URL(name, root), "utf8"));
const manifest = read("package.json");
const { contributes } = manifest;
const language = read("language-configuration.json");

test("every command has a title and something that it runs, and nothing else is registered", async () => {
  const { extension, done } = inEditor({ settings: { "tweeze.path": "/no/such/tweeze" } });
  await extension.activate({ subscriptions: [] });
  assert.deepEqual(contributes.commands.map(({ command }) => command).sort(), [...done.commands.keys()].sort());
  const titles = contributes.commands.map(({ category, title }) => `${category}: ${title}`);
  assert.deepEqual(titles, ["Tweeze: Build This Program", "Tweeze: View This Program", "Tweeze: Restart Server"]);
  const named = Object.values(contributes.menus).flat().map(({ command }) => command);
  assert.ok(named.every((command) => done.commands.has(command)));
});

test("every file that is named is there", () => {
  const files = [contributes.languages[0].configuration, contributes.grammars[0].path, contributes.snippets[0].path];
  for (const file of files) assert.ok(existsSync(new URL(file, root)), file);
  assert.equal(read(contributes.grammars[0].path).scopeName, contributes.grammars[0].scopeName);
});

test("versions are exact, and the lock file names no registry", () => {
  for (const [name, version] of Object.entries(manifest.devDependencies)) assert.match(version, /^\d+\.\d+\.\d+$/u, name);
  assert.doesNotMatch(readFileSync(new URL("package-lock.json", root), "utf8"), /"resolved"/u);
});

const [pattern] = contributes.problemPatterns;
const matched = (line) => {
  const found = new RegExp(pattern.regexp, "u").exec(line);
  return found && Object.fromEntries(["file", "line", "column", "severity", "code", "message"].map((part) => [part, found[pattern[part]]]));
};

test("the problem matcher reads the lines of `--format short`", () => {
  assert.equal(contributes.problemMatchers[0].pattern, `$${pattern.name}`);
  const lines = [
    ["fetch.twz:21:11: error[E0503]: title: with 3:4: in it", "fetch.twz", "21", "11", "error", "E0503", "title: with 3:4: in it"],
    ["C:\\lab one\\fetch.twz:3:5: warning[W0201]: value `unused` is never used", "C:\\lab one\\fetch.twz", "3", "5", "warning", "W0201", "value `unused` is never used"],
    ["/lab/a:1:2.twz:8:3: error[E0601]: no plan leads from (0, 0) to (1, 3)", "/lab/a:1:2.twz", "8", "3", "error", "E0601", "no plan leads from (0, 0) to (1, 3)"],
  ];
  for (const [text, file, line, column, severity, code, message] of lines) {
    assert.deepEqual(matched(text), { file, line, column, severity, code, message }, text);
  }
  // Diagnostics without a source location, and lines of the report.
  const others = [
    "error[E0801]: cannot read `nothere.twz`: no such file or directory",
    "  Planned  go                      6.83 um (2 r) in 2 switches, optimal (bound 6.83 um)",
    "    Wrote  out/go.mcap             8 channels, 2 actuations, 30 ms, 60 mJ",
    " Watching  1 file  Ctrl-C ends",
  ];
  for (const text of others) assert.equal(matched(text), null, text);
});

const executable = process.env.TWEEZE;
test("the problem matcher reads what tweeze prints", { skip: executable ? false : "TWEEZE names no executable" }, () => {
  const folder = mkdtempSync(path.join(tmpdir(), "tweeze-problems-"));
  try {
    const file = path.join(folder, "a 1.twz");
    const begin = "use std.dimibot\n\nlet unused = 3\n\ndevice bot : dimibot.femto_st\n\ntask go on bot { move to ";
    const cases = [
      ["(1, 1)", 0, ["3", "5", "warning", "W0201", "value `unused` is never used"]],
      ["nowhere", 1, ["7", "26", "error", "E0201", "no value is named `nowhere`"]],
    ];
    for (const [goal, exit, expected] of cases) {
      writeFileSync(file, `${begin}${goal} }\n`);
      const { status, stderr } = spawnSync(executable, ["build", "--format", "short", "--output", folder, "--", file], { encoding: "utf8" });
      assert.equal(status, exit, stderr);
      const found = stderr.trimEnd().split("\n").map((line) => Object.values(matched(line) ?? {}));
      assert.deepEqual(found, [[file, ...expected]], stderr);
    }
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test("a line that opens a bracket indents what follows, one that closes it does not", () => {
  const { increaseIndentPattern, decreaseIndentPattern } = language.indentationRules;
  const [more, less] = [increaseIndentPattern, decreaseIndentPattern].map((text) => new RegExp(text, "u"));
  for (const line of ["scene bench {", "  robots: table {", "let a = [", "  together {  // both", '  a -> "x//y" {', "let b = 4 / f("]) assert.match(line, more);
  for (const line of ["scene bench { }", "// scene bench {", "  move to (1, 2)", "}", 'x -> "a {"', "let a = 3 // {", "/// {"]) assert.doesNotMatch(line, more);
  for (const line of ["}", "  ]", ")", "} "]) assert.match(line, less);
  for (const line of ["move to (1, 2) }", "// }"]) assert.doesNotMatch(line, less);
});

test("documentation goes on in the next line, other comments do not", () => {
  const appended = (line) => language.onEnterRules.find(({ beforeText }) => new RegExp(beforeText, "u").test(line))?.action.appendText;
  assert.equal(appended("/// Carries the tip"), "/// ");
  assert.equal(appended("  ///"), "/// ");
  assert.equal(appended("//! A file"), "//! ");
  for (const line of ["// comment", "//// rule", "move to (1, 2) /// late", ""]) assert.equal(appended(line), undefined, line);
});

test("a word of the editor is a name, a number or a word of bits", () => {
  const { pattern: words, flags } = language.wordPattern;
  const found = "let pitch_2 = 0b01_10 + 3.5e-3 µm".match(new RegExp(words, `g${flags}`));
  assert.deepEqual(found, ["let", "pitch_2", "0b01_10", "3.5e-3", "µm"]);
});
