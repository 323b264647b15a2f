import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import { grammarFile, grammarText } from "../../scripts/grammar.mjs";
import { scopesOf } from "./grammar.mjs";
import { piecesOf, programs, words } from "./programs.mjs";

const isKeyword = (scope) => /^(keyword(?!\.other\.unit|\.operator)|constant\.language)\./u.test(scope);
const isUnit = (scope) => scope === "keyword.other.unit.tweeze";

/** The words that may have the scope of a keyword. */
const colourable = new Set([words.reserved, words.steps, words.step_nouns, words.nouns].flat());

/** Yields every piece of every program with the scopes of its columns. */
function* pieces() {
  for (const { name, text } of programs) {
    for (const [at, { line, columns }] of scopesOf(text).entries()) {
      for (const piece of piecesOf(line)) {
        const where = `${name}:${at + 1}:${piece.from + 1}: ${piece.text}`;
        yield { ...piece, where, line, scopes: columns.slice(piece.from, piece.to) };
      }
    }
  }
}

test("the committed grammar is what the script writes from words.json", () => {
  assert.equal(readFileSync(grammarFile, "utf8"), grammarText(), "run `npm run grammar`");
});

test("every list of words is sorted, without doubles, and the reserved words are those that have a role", () => {
  for (const [list, own] of Object.entries(words)) {
    assert.deepEqual(own, [...new Set(own)].sort(), list);
  }
  const { declarations, prepositions, truths, reserved } = words;
  assert.deepEqual([...declarations, ...prepositions, ...truths, "as", "table"].sort(), reserved);
  // A word in two lists would only be coloured by the first pattern.
  const all = [reserved, words.steps, words.nouns, words.functions, words.step_nouns].flat();
  assert.deepEqual(all.filter((word, at) => all.indexOf(word) !== at), []);
});

test("the programs are there", () => {
  assert.ok(programs.length >= 30, `${programs.length} programs`);
  const found = new Set([...pieces()].map(({ kind }) => kind));
  assert.deepEqual([...found].sort(), ["comment", "number", "string", "word"]);
});

test("comments and strings hold nothing else", () => {
  for (const { kind, where, scopes } of pieces()) {
    if (kind !== "comment" && kind !== "string") continue;
    const own = kind === "comment" ? "comment.line." : "string.quoted.";
    for (const column of scopes) {
      assert.ok(column.some((scope) => scope.startsWith(own)), where);
      assert.ok(!column.some((scope) => isKeyword(scope) || isUnit(scope)), where);
    }
  }
});

test("every reserved word is a keyword, but where it is a field or behind a dot", () => {
  const seen = new Set();
  for (const { kind, text, where, scopes, isField, isMember } of pieces()) {
    if (kind !== "word" || !words.reserved.includes(text)) continue;
    for (const column of scopes) {
      assert.equal(column.some(isKeyword), !isField && !isMember, where);
      if (isField) assert.ok(column.includes("variable.other.property.tweeze"), where);
    }
    seen.add(text);
  }
  assert.deepEqual(words.reserved.filter((word) => !seen.has(word)), [], "reserved words that no program has");
});

test("no other word is a keyword", () => {
  for (const { kind, text, where, scopes, isField, isMember } of pieces()) {
    if (kind !== "word" || (colourable.has(text) && !isField && !isMember)) continue;
    assert.ok(!scopes.some((column) => column.some(isKeyword)), where);
  }
});

test("a step or a noun that begins a line of a task or a scene is a keyword", () => {
  const seen = new Set();
  let inside = "";
  for (const { kind, text, where, line, from, scopes, isField } of pieces()) {
    if (from === 0) inside = text;
    const known = inside === "scene" ? words.nouns : ["task", "program"].includes(inside) ? words.steps : [];
    if (kind !== "word" || isField || line.slice(0, from).trim() !== "" || !known.includes(text)) continue;
    assert.ok(scopes.every((column) => column.some(isKeyword)), where);
    seen.add(text);
  }
  const missing = [...words.steps, ...words.nouns].filter((word) => !seen.has(word));
  assert.deepEqual(missing, [], "steps and nouns that begin no line");
});

test("every number has its scope, and so has every unit behind one", () => {
  const units = new Set(words.units);
  for (const prefix of ["", ...words.prefixes]) words.prefixed_units.forEach((unit) => units.add(prefix + unit));
  let count = 0;
  for (const { kind, text, where, line, from, scopes } of pieces()) {
    if (kind === "number") {
      // An exponent belongs to its unit.
      if (scopes.every((column) => column.some(isUnit)) && line[from - 1] === "^") continue;
      assert.ok(scopes.every((column) => column.some((scope) => scope.startsWith("constant.numeric."))), where);
    } else if (kind === "word" && /(^|[^\p{Alphabetic}0-9_])[0-9][0-9_.]* $/u.test(line.slice(0, from)) && units.has(text)) {
      assert.ok(scopes.every((column) => column.some(isUnit)), where);
      count += 1;
    }
  }
  assert.ok(count > 400, `${count} units`);
});

test("no context is left open behind a program", () => {
  for (const { name, text } of programs) {
    const lines = scopesOf(text);
    const [first, last] = [scopesOf("")[0], lines.at(-1)];
    assert.equal(last.depth, first.depth, name);
    // Nor after any of its declarations.
    lines.filter(({ line }) => line === "}").forEach(({ depth }) => assert.equal(depth, first.depth, name));
  }
});

test("a bracket or a string that is left open spoils its own declaration alone", () => {
  for (const broken of ["let a = [(1, 2", "scene s {\n  obstacle o at (1, 2", "task go(p: cell", "device d : x { t: table { a | b", 'let a = "b']) {
    const [line] = scopesOf(`${broken}\ndevice bot : dimibot { left: 5 }`).slice(-1);
    const scopesAt = (text) => line.columns[line.line.indexOf(text)].at(-1);
    assert.equal(scopesAt("device"), "keyword.declaration.tweeze", broken);
    assert.equal(scopesAt("bot"), "entity.name.type.tweeze", broken);
    assert.equal(scopesAt("left"), "variable.other.property.tweeze", broken);
  }
});

test("words that only begin or end like a word of the language have no scope of a keyword", () => {
  for (const word of [...colourable, ...words.truths]) {
    for (const own of [`${word}_light`, `${word}2`, `my_${word}`, `${word}é`]) {
      for (const line of [`  ${own}`, `  move ${own} to ${own}`, `  ${own}: ${own}`, `let ${own} = ${own} + 1`]) {
        const [{ columns }] = scopesOf(line);
        const at = line.lastIndexOf(own);
        assert.ok(columns.slice(at, at + own.length).every((column) => !column.some(isKeyword)), line);
      }
    }
  }
});
