import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import test from "node:test";
import hljs from "highlight.js/lib/core";
import tweeze from "../tweeze.js";
import words from "../words.js";
import { wordsFile, wordsText } from "../scripts/words.js";

hljs.registerLanguage("tweeze", tweeze);

const examples = new URL("../../../examples/", import.meta.url);
const programs = readdirSync(examples).filter((name) => name.endsWith(".twz")).sort()
  .map((name) => ({ name, text: readFileSync(new URL(name, examples), "utf8") }));

const ENTITIES = { "&lt;": "<", "&gt;": ">", "&amp;": "&", "&quot;": '"', "&#x27;": "'" };

/** The scopes of each character of a text, such as `title.function`, outermost first; empty where there is none. */
function scopesOf(text) {
  const scopes = [];
  const open = [];
  for (const [part, end, names] of hljs.highlight(text, { language: "tweeze" }).value.matchAll(/(<\/span>)|<span class="([^"]*)">|&[#\w]+;|[^]/gu)) {
    if (end) open.pop();
    else if (names !== undefined) open.push(names.replace("hljs-", "").replace(/_+(?= |$)/gu, "").replaceAll(" ", "."));
    else for (let unit = 0; unit < (ENTITIES[part] ?? part).length; unit += 1) scopes.push([...open]);
  }
  assert.equal(scopes.length, text.length);
  return scopes;
}

/** The pieces of a line as `scope:text`; text without a scope is left out. */
function rolesOf(text) {
  const roles = [];
  let last = "";
  scopesOf(text).forEach((scopes, at) => {
    const scope = scopes.join(">");
    if (scope === "" || /\s/u.test(text[at]) && scope !== last) return void (last = "");
    if (scope === last) roles[roles.length - 1] += text[at];
    else roles.push(`${scope}:${text[at]}`);
    last = scope;
  });
  return roles;
}

test("words.js is what the script writes from words.json", () => {
  assert.equal(readFileSync(wordsFile, "utf8"), wordsText(), "run `npm run words`");
});

test("words have the roles of their places", () => {
  const cases = [
    ["use std.dimibot as d // use", ["keyword:use", "title.class:std.dimibot", "keyword:as", "comment:// use"]],
    ["let pitch = 70 um/s", ["keyword:let", "variable.constant:pitch", "operator:=", "number:70 um/s"]],
    ["device bot : d.femto_st { left: 5 }", ["keyword:device", "title.class:bot", "title.class.inherited:d.femto_st", "attr:left", "number:5"]],
    ["output light : digital", ["keyword:output", "title.class:light", "title.class.inherited:digital"]],
    ["task go(goal: cell) on bot in lab.bench {", ["keyword:task", "title.function:go", "params:goal", "type:cell", "keyword:on", "keyword:in"]],
    ["program day { run go((1, 1)) }", ["keyword:program", "title.function:day", "keyword:run", "title.function:go", "number:1", "number:1"]],
    ["  obstacle bead : disc { radius: 0.8 um } at (4.0 um, 2)", ["keyword:obstacle", "variable:bead", "title.class.inherited:disc", "attr:radius", "number:0.8 um", "keyword:at", "number:4.0 um", "number:2"]],
    ["wiring bot { out -> card.port0 { gain: 2 } }", ["keyword:wiring", "operator:->", "attr:gain", "number:2"]],
    ["  minimize distance, precision: 2 %", ["keyword:minimize", "property:distance", "attr:precision", "number:2 %"]],
    ["  apply state 0b10 for 2 s", ["keyword:apply", "keyword:state", "number:0b10", "keyword:for", "number:2 s"]],
    ["  bl[0].set -> \"line{2*i}{{\"", ["number:0", "operator:->", "string:\"line", "string>subst:{", "string>subst>number:2", "string>subst>operator:*", "string>subst:i}", "string>char.escape:{{", "string:\""]],
    ["  mirrored: false, from: (2, 3)", ["attr:mirrored", "literal:false", "attr:from", "number:2", "number:3"]],
    ["let p = min(5 min, pose(1 um, 2 um))", ["keyword:let", "variable.constant:p", "operator:=", "built_in:min", "number:5 min", "built_in:pose", "number:1 um", "number:2 um"]],
    ["for i, p in pads { move to p }", ["keyword:for", "keyword:in", "keyword:move", "keyword:to"]],
    ["  t: table {\n  robot | u [um/s]\n  D1 | 3 um }", ["attr:t", "keyword:table", "attr:robot", "attr:u", "number:um/s", "number:3 um"]],
  ];
  for (const [line, expected] of cases) assert.deepEqual(rolesOf(line), expected, line);
});

test("words that only begin or end like a word of the language have no role", () => {
  for (const word of [words.reserved, words.steps, words.nouns].flat()) {
    for (const own of [`${word}_light`, `my_${word}`, `${word}2`]) assert.deepEqual(rolesOf(`  ${own} = a.${word}`), ["operator:="], own);
  }
});

test("examples: comments and strings hold nothing else, and every reserved word has its role", () => {
  assert.ok(programs.length >= 20);
  for (const { name, text } of programs) {
    const scopes = scopesOf(text);
    const token = /(?<comment>\/\/.*)|(?<string>"[^"]*")|(?<word>(?<![.\p{Alphabetic}0-9_])[\p{Alphabetic}_][\p{Alphabetic}0-9_]*)|(?<number>(?<![\p{Alphabetic}0-9_^])[0-9]+)/gu;
    for (const { groups, index, 0: piece } of text.matchAll(token)) {
      const own = scopes.slice(index, index + piece.length);
      const has = (wanted) => own.every((outer) => outer.includes(wanted));
      const where = `${name}: ${piece}: ${own[0]}`;
      const isField = /^[ \t]*:/u.test(text.slice(index + piece.length)) && /(^|[\n{},])[ \t]*$/u.test(text.slice(0, index));
      if (groups.comment) assert.ok(has("comment") && own.every((outer) => outer.length === 1), where);
      else if (groups.string) assert.ok(has("string") && !own.some((outer) => outer.includes("keyword")), where);
      else if (groups.number) assert.ok(has("number"), where);
      else if (isField) assert.ok(has("attr") || has("params"), where);
      else if (words.reserved.includes(piece)) assert.ok(has(words.truths.includes(piece) ? "literal" : "keyword"), where);
      else if (![words.steps, words.nouns, words.step_nouns].flat().includes(piece)) assert.ok(!has("keyword"), where);
    }
  }
});

test("examples are found to be Tweeze among the usual languages", async () => {
  const { default: all } = await import("highlight.js/lib/common");
  all.registerLanguage("tweeze", tweeze);
  for (const { name, text } of programs) assert.equal(all.highlightAuto(text).language, "tweeze", name);
});
