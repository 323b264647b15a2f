/*
Language: Tweeze
Description: A declarative language for micro-manipulation programs (.twz)
Category: scientific
*/
import words from "./words.js";

const literal = (text) => text.replace(/[\\^$.*+?()[\]{}|/]/gu, "\\$&");

/** Pattern for any of these words, longest first so that no word hides a longer one. */
const oneOf = (list) => [...list].sort((a, b) => b.length - a.length || (a < b ? -1 : 1)).map(literal).join("|");

/** The language, for `hljs.registerLanguage("tweeze", tweeze)`. */
export default function tweeze() {
  // Most roles follow from the position of a word in its line. The punctuation before an entry is matched with it, and words are matched
  // whole, because not every browser supports lookbehind.
  const char = String.raw`[\p{Alphabetic}0-9_]`;
  const ends = `(?!${char})`;
  const word = String.raw`[\p{Alphabetic}_]${char}*`;
  const name = `(?!(?:${oneOf(words.reserved)})${ends})${word}`;
  const path = String.raw`${name}(?:\.${word})*`;
  const head = String.raw`(?:^|[{},])[ \t]*`;
  const blanks = String.raw`[ \t]+`;
  const digits = "[0-9][0-9_]*";
  const number = String.raw`${digits}(?:\.${digits})?(?:[eE][+-]?${digits})?`;
  const names = oneOf(words.units.filter((unit) => unit !== "%"));
  const power = String.raw`(?:%|(?:${names}|(?:${oneOf(words.prefixes)})?(?:${oneOf(words.prefixed_units)}))${ends})(?:\^-?[0-9]+)?`;
  const unit = `${power}(?:[*/]${power})*`;
  const isSetting = (step) => ["minimize", "require", "using"].includes(step);

  /** A mode for consecutive pieces, given as pairs of a pattern and its scope. */
  const pieces = (...pairs) => ({
    match: pairs.map(([pattern]) => new RegExp(pattern, "u")),
    scope: Object.fromEntries(pairs.flatMap(([, scope], at) => (scope ? [[at + 1, scope]] : []))),
    relevance: 0,
  });
  const piece = (pattern, scope) => ({ match: new RegExp(pattern, "u"), ...(scope && { scope }), relevance: 0 });
  const afterHead = (list, ...rest) => pieces([head], [`(?:${oneOf(list)})${ends}`, "keyword"], ...rest);

  const COMMENT = { scope: "comment", begin: /\/\//u, end: /$/u };
  const NUMBER = piece(String.raw`0b[01_]+${ends}|${number}(?:[ \t]*${unit})?`, "number");
  const FUNCTION = piece(String.raw`(?:${oneOf(words.functions)})(?=[ \t]*\()`, "built_in");
  const OPERATOR = piece(`->|${oneOf(words.operators)}|=`, "operator");
  // After a dot any word is a name.
  const MEMBER = piece(String.raw`\.[ \t]*${word}`);
  const NAME = piece(word);
  const HOLE = { scope: "subst", begin: /\{/u, end: /\}|(?=["\n])/u, contains: [NUMBER, FUNCTION, OPERATOR, MEMBER, NAME] };
  const STRING = { scope: "string", begin: /"/u, end: /"|$/u, contains: [piece(String.raw`\{\{`, "char.escape"), HOLE] };
  const RESERVED = [piece(`(?:${oneOf(words.truths)})${ends}`, "literal"), piece(`(?:${oneOf(words.reserved)})${ends}`, "keyword")];
  const CALL = piece(String.raw`${word}(?=[ \t]*\()`, "title.function");
  const VALUES = [COMMENT, STRING, NUMBER, FUNCTION, ...RESERVED, OPERATOR, MEMBER];
  const BRACKETS = [[/\(/u, /\)/u], [/\[/u, /\]/u]].map(([begin, end]) => ({ begin, end, contains: [] }));
  BRACKETS.forEach((bracket) => bracket.contains.push(...VALUES, CALL, ...BRACKETS, NAME));
  const PARAMETERS = { begin: /\(/u, end: /\)/u, contains: [COMMENT, pieces([word, "params"], [String.raw`[ \t]*:[ \t]*`], [word, "type"])] };
  const TABLE = {
    // Up to the end of the first line, which has the names of the columns.
    begin: [/table/u, /[ \t]*\{\s*/u],
    beginScope: { 1: "keyword" },
    end: /$|(?=\})/u,
    contains: [COMMENT, pieces([String.raw`\[[ \t]*`], [unit, "number"], [String.raw`[ \t]*\]`]), piece(word, "attr")],
    starts: { end: /\}/u, contains: [...VALUES, ...BRACKETS, NAME] },
  };
  const TASK = {
    begin: [new RegExp(head, "u"), /task|program/u, new RegExp(blanks, "u"), new RegExp(name, "u")],
    beginScope: { 2: "keyword", 4: "title.function" },
    end: /(?=[ \t]*[^ \t(])|\)/u,
    relevance: 5,
    contains: [{ ...PARAMETERS, endsParent: true }],
  };

  return {
    name: "Tweeze",
    aliases: ["twz"],
    unicodeRegex: true,
    contains: [
      COMMENT,
      pieces([head], [word, "attr"], [String.raw`[ \t]*:(?!=)`]),
      // No other language has such lines, hence the high relevance.
      { ...afterHead(["use"], [blanks], [String.raw`std(?:\.${word})+`, "title.class"]), relevance: 10 },
      TASK,
      { ...afterHead(["device", "instrument", "output", "scene"], [blanks], [name, "title.class"]), relevance: 1 },
      afterHead(["let"], [blanks], [name, "variable.constant"]),
      afterHead(["wiring"], [blanks], [path]),
      pieces([head], ["for", "keyword"], [blanks], [String.raw`${name}(?:[ \t]*,[ \t]*${name})?`], [blanks], [`in${ends}`, "keyword"], [`(?:${blanks}${path})?`]),
      afterHead(words.declarations),
      afterHead(words.nouns, [blanks], [name, "variable"]),
      afterHead(words.steps.filter(isSetting), [blanks], [name, "property"]),
      afterHead(["run"], [blanks], [path, "title.function"]),
      afterHead(words.steps, [blanks], [oneOf(words.step_nouns), "keyword"], [String.raw`(?=[ \t]+["0-9\p{Alphabetic}_])`]),
      afterHead([...words.nouns, ...words.steps]),
      TABLE,
      pieces(["->", "operator"], [String.raw`[ \t]*`], [path]),
      pieces([`(?:in|on)${ends}`, "keyword"], [blanks], [path]),
      pieces([String.raw`:(?!=)[ \t]*`], [path, "title.class.inherited"]),
      COMMENT,
      STRING,
      NUMBER,
      FUNCTION,
      ...RESERVED,
      piece(String.raw`${path}(?=[ \t]*\{)`, "title.class"),
      CALL,
      OPERATOR,
      MEMBER,
      ...BRACKETS,
      NAME,
    ],
  };
}
