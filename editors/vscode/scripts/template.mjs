// The TextMate grammar, with placeholders for the words, which `grammar.mjs` fills in from `words.json`.
//
// As in the language server, most roles follow from the position of a word in its line: a step, a noun or a field begins an entry,
// after the start of a line, a brace or a comma. Parentheses and square brackets are contexts of their own, in which no entry begins.
// Patterns use Oniguruma syntax.

/** Escapes the special characters of regular expressions. */
const literal = (text) => text.replace(/[\\^$.*+?()[\]{}|/-]/gu, "\\$&");

/** Pattern for any of these words, longest first so that no word hides a longer one. */
const oneOf = (words) => [...words].sort((a, b) => b.length - a.length || (a < b ? -1 : 1)).map(literal).join("|");

/** The grammar as an object, with keys in the order of the file. */
export function grammarOf(words) {
  // `letter` and `word_char` of grammar/lexis.pest.
  const char = String.raw`[\p{Alphabetic}0-9_]`;
  const word = String.raw`[\p{Alphabetic}_]${char}*`;
  const path = String.raw`${word}(?:\.${word})*`;
  const ends = `(?!${char})`;
  const blank = String.raw`[ \t]`;
  // After a dot any word is a name, as in `bl0.set`; after the two dots of a range, words keep their roles.
  const begins = String.raw`(?:(?<![\p{Alphabetic}0-9_.])|(?<=\.\.))`;
  const head = `(?:^|(?<=[{},]))${blank}*`;
  const reserved = oneOf(words.reserved);
  const name = `(?!(?:${reserved})${ends})${word}`;
  // A declaration never occurs in a bracket: one at the start of a line closes what was left open above it.
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
    // Includes the newline, so that no context ends after a comment.
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
            // The noun of a step is followed by its object, as in `apply state 2`.
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
            // The first line with a name or a unit: the column headers.
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
      // Tokens that may also occur in the braces of a string.
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
