// The TextMate grammar, with places for the words. `grammar.mjs` fills them in from `words.json`.
//
// As in the language server, most roles come from where a word stands in its line: a step, a noun or a field begins an entry,
// behind a line's begin, a brace or a comma. Round and square brackets are contexts of their own, in which no entry begins.
// Patterns are in Oniguruma's notation.

/** Escapes what a regular expression would read as its own. */
const literal = (text) => text.replace(/[\\^$.*+?()[\]{}|/-]/gu, "\\$&");

/** One of these words; the longest are tried first, so that none hides another one. */
const oneOf = (words) => [...words].sort((a, b) => b.length - a.length || (a < b ? -1 : 1)).map(literal).join("|");

/** The grammar as an object; its order is that of the file. */
export function grammarOf(words) {
  // `letter` and `word_char` of grammar/lexis.pest.
  const char = String.raw`[\p{Alphabetic}0-9_]`;
  const word = String.raw`[\p{Alphabetic}_]${char}*`;
  const path = String.raw`${word}(?:\.${word})*`;
  const ends = `(?!${char})`;
  const blank = String.raw`[ \t]`;
  // Behind a dot any word is a name, as in `bl0.set`; behind the two dots of a range none is.
  const begins = String.raw`(?:(?<![\p{Alphabetic}0-9_.])|(?<=\.\.))`;
  const head = `(?:^|(?<=[{},]))${blank}*`;
  const reserved = oneOf(words.reserved);
  const name = `(?!(?:${reserved})${ends})${word}`;
  // A declaration never stands in a bracket: one at a line's begin ends what was left open above it.
  const nextItem = `(?=^(?:${oneOf(words.declarations)})${blank}+["\\p{Alphabetic}_])`;

  const digits = "[0-9][0-9_]*";
  const number = String.raw`${digits}(?:\.${digits})?(?:[eE][+-]?${digits})?`;
  const oneUnit = `(?:(?:${oneOf(words.units.filter((unit) => unit !== "%"))})${ends}|%|(?:${oneOf(words.prefixes)})?(?:${oneOf(words.prefixed_units)})${ends})`;
  const power = String.raw`${oneUnit}(?:\^-?[0-9]+)?`;
  const unit = `${power}(?:[*/]${power})*`;

  const isSetting = (step) => ["minimize", "require", "using"].includes(step);
  const settings = words.steps.filter(isSetting);
  const steps = words.steps.filter((step) => !isSetting(step));
  const based = ["device", "instrument", "output", "scene"];
  const called = ["program", "task"];

  const scope = (own) => ({ name: `${own}.tweeze` });
  const include = (...names) => names.map((own) => ({ include: `#${own}` }));
  const comment = (mark, sort) => ({
    // The line's end is part of it, so that no context ends behind a comment.
    match: `(${mark}).*\\n?`,
    name: `comment.line.${sort}.tweeze`,
    captures: { 1: scope("punctuation.definition.comment") },
  });
  const bracket = (open, close, sort, patterns) => ({
    begin: literal(open),
    end: `(${literal(close)})|${nextItem}`,
    beginCaptures: { 0: scope(`punctuation.section.${sort}.begin`) },
    endCaptures: { 1: scope(`punctuation.section.${sort}.end`) },
    patterns,
  });
  const pathOf = (own) => ({
    patterns: [
      { match: String.raw`${word}(?=\.)`, ...scope("entity.name.namespace") },
      { match: String.raw`\.`, ...scope("punctuation.accessor") },
      { match: word, ...scope(own) },
    ],
  });

  return {
    information_for_contributors: [
      "Written by scripts/grammar.mjs from scripts/template.mjs and ../words.json: change those, and run `npm run grammar`.",
    ],
    name: "Tweeze",
    scopeName: "source.tweeze",
    fileTypes: ["twz"],
    patterns: include("entries"),
    repository: {
      entries: {
        patterns: include(
          "comments", "field", "use", "parameters", "declaration", "loop", "object", "setting", "run", "step", "table", "block",
          "wire", "place", "base", "expression",
        ),
      },
      comments: {
        patterns: [
          comment("//!|///(?!/)", "documentation"),
          comment("//", "double-slash"),
        ],
      },
      field: {
        match: `${head}(${word})${blank}*(:)(?!=)`,
        captures: { 1: scope("variable.other.property"), 2: scope("punctuation.separator.colon") },
      },
      use: {
        begin: `${head}(use)${ends}`,
        end: `(?=${blank}*(?:,|//|$))`,
        beginCaptures: { 1: scope("keyword.control.import") },
        patterns: [
          ...include("string"),
          { match: `${begins}(as)${ends}`, ...scope("keyword.control.import") },
          { match: path, captures: { 0: pathOf("entity.name.namespace") } },
        ],
      },
      parameters: {
        begin: `${head}(${oneOf(called)})${blank}+(${name})${blank}*(\\()`,
        end: `(\\))|${nextItem}`,
        beginCaptures: {
          1: scope("keyword.declaration"),
          2: scope("entity.name.function"),
          3: scope("punctuation.section.parameters.begin"),
        },
        endCaptures: { 1: scope("punctuation.section.parameters.end") },
        patterns: [
          ...include("comments"),
          {
            match: `(${word})${blank}*(:)${blank}*(${word})`,
            captures: { 1: scope("variable.parameter"), 2: scope("punctuation.separator.colon"), 3: scope("support.type") },
          },
          ...include("comma"),
        ],
      },
      declaration: {
        patterns: [
          {
            match: `${head}(${oneOf(called)})${blank}+(${name})`,
            captures: { 1: scope("keyword.declaration"), 2: scope("entity.name.function") },
          },
          {
            match: `${head}(${oneOf(based)})${blank}+(${name})`,
            captures: { 1: scope("keyword.declaration"), 2: scope("entity.name.type") },
          },
          {
            match: `${head}(let)${blank}+(${name})`,
            captures: { 1: scope("keyword.declaration"), 2: scope("variable.other.constant") },
          },
          {
            match: `${head}(wiring)${blank}+(${path})`,
            captures: { 1: scope("keyword.declaration"), 2: pathOf("variable.other") },
          },
          { match: `${head}(${oneOf(words.declarations)})${ends}`, captures: { 1: scope("keyword.declaration") } },
        ],
      },
      loop: {
        match: `${head}(for)${blank}+(${name})(?:${blank}*(,)${blank}*(${name}))?${blank}+(in)${ends}(?:${blank}+(${path})(?=${blank}*\\{))?`,
        captures: {
          1: scope("keyword.control.loop"),
          2: scope("variable.other"),
          3: scope("punctuation.separator.comma"),
          4: scope("variable.other"),
          5: scope("keyword.control.loop"),
          6: pathOf("variable.other"),
        },
      },
      object: {
        match: `${head}(${oneOf(words.nouns)})${ends}(?:${blank}+(${name}))?`,
        captures: { 1: scope("keyword.declaration.object"), 2: scope("variable.other.object") },
      },
      setting: {
        match: `${head}(${oneOf(settings)})${ends}(?:${blank}+(${name}))?`,
        captures: { 1: scope("keyword.control.setting"), 2: scope("variable.other.property") },
      },
      run: {
        match: `${head}(run)${blank}+(${path})`,
        captures: { 1: scope("keyword.control.step"), 2: pathOf("entity.name.function") },
      },
      step: {
        patterns: [
          {
            // The noun of a step has its object behind it, as in `apply state 2`.
            match: `${head}(${oneOf(steps)})${blank}+(${oneOf(words.step_nouns)})(?=${blank}+(?:["0-9]|${name}))`,
            captures: { 1: scope("keyword.control.step"), 2: scope("keyword.control.step") },
          },
          { match: `${head}(${oneOf(steps)})${ends}`, captures: { 1: scope("keyword.control.step") } },
        ],
      },
      table: {
        begin: `${begins}(table)${blank}*(\\{)`,
        end: `(\\})|${nextItem}`,
        beginCaptures: { 1: scope("keyword.other.table"), 2: scope("punctuation.section.table.begin") },
        endCaptures: { 1: scope("punctuation.section.table.end") },
        patterns: [
          {
            // The first line in which a name or a unit stands.
            begin: String.raw`(?<=\{)`,
            end: `(?<=[\\p{Alphabetic}0-9_\\]])(?=${blank}*(?://|$|\\}))|(?=\\})|${nextItem}`,
            patterns: [
              ...include("comments", "bar"),
              {
                match: `(\\[)${blank}*(${unit})?${blank}*(\\])`,
                captures: {
                  1: scope("punctuation.section.brackets.begin"),
                  2: scope("keyword.other.unit"),
                  3: scope("punctuation.section.brackets.end"),
                },
              },
              { match: word, ...scope("variable.other.property") },
            ],
          },
          ...include("comments", "bar", "expression"),
        ],
      },
      bar: { match: String.raw`\|`, ...scope("punctuation.separator.bar") },
      block: bracket("{", "}", "block", include("entries")),
      wire: {
        match: `(->)(?:${blank}*(${path}))?`,
        captures: { 1: scope("keyword.operator.arrow"), 2: { patterns: include("value") } },
      },
      place: {
        match: `${begins}(in|on)${blank}+(${name}(?:\\.${word})*)`,
        captures: { 1: scope("keyword.other.preposition"), 2: pathOf("variable.other") },
      },
      base: {
        match: `(:)(?!=)${blank}*(?!(?:${reserved})${ends})(${path})?`,
        captures: { 1: scope("punctuation.separator.colon"), 2: pathOf("entity.other.inherited-class") },
      },
      expression: {
        patterns: [
          ...include("comments", "string", "reserved"),
          { match: `${begins}(${path})(?=${blank}*\\{)`, captures: { 1: pathOf("entity.name.type") } },
          ...include("value"),
        ],
      },
      reserved: {
        patterns: [
          { match: `${begins}(?:${oneOf(words.truths)})${ends}`, ...scope("constant.language.boolean") },
          { match: `${begins}(?:${oneOf(words.prepositions)})${ends}`, ...scope("keyword.other.preposition") },
          { match: `${begins}(?:${oneOf(words.reserved.filter((one) => !words.truths.includes(one)))})${ends}`, ...scope("keyword.other") },
        ],
      },
      // What may also stand in the braces of a string.
      value: {
        patterns: [
          { match: `(?<!${char})0b[01_]+${ends}`, ...scope("constant.numeric.binary") },
          {
            match: `(?<!${char})(${number})(?:${blank}*(${unit})(?!${blank}*(?::|=(?!=))))?`,
            captures: { 1: scope("constant.numeric.decimal"), 2: scope("keyword.other.unit") },
          },
          { match: String.raw`->`, ...scope("keyword.operator.arrow") },
          { match: oneOf(words.operators), ...scope("keyword.operator") },
          { match: "=", ...scope("keyword.operator.assignment") },
          {
            match: `(\\.)${blank}*(${word})`,
            captures: { 1: scope("punctuation.accessor"), 2: scope("variable.other.member") },
          },
          { match: `${begins}(?:${oneOf(words.functions)})(?=${blank}*\\()`, ...scope("support.function.builtin") },
          { match: `${begins}${word}(?=${blank}*\\()`, ...scope("entity.name.function") },
          { match: `${begins}${word}`, ...scope("variable.other") },
          ...include("comma", "parens", "brackets"),
        ],
      },
      comma: { match: ",", ...scope("punctuation.separator.comma") },
      parens: bracket("(", ")", "parens", include("expression")),
      brackets: bracket("[", "]", "brackets", include("expression")),
      string: {
        begin: '"',
        end: '(")|$',
        name: "string.quoted.double.tweeze",
        beginCaptures: { 0: scope("punctuation.definition.string.begin") },
        endCaptures: { 1: scope("punctuation.definition.string.end") },
        patterns: [
          { match: String.raw`\{\{`, ...scope("constant.character.escape") },
          {
            begin: String.raw`\{`,
            end: String.raw`(\})|(?="|$)`,
            name: "meta.interpolation.tweeze",
            beginCaptures: { 0: scope("punctuation.section.interpolation.begin") },
            endCaptures: { 1: scope("punctuation.section.interpolation.end") },
            patterns: include("value"),
          },
        ],
      },
    },
  };
}
