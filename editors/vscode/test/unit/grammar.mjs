// The grammar, read as the editor reads it.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import oniguruma from "vscode-oniguruma";
import textmate from "vscode-textmate";
import { grammarFile } from "../../scripts/grammar.mjs";

const require = createRequire(import.meta.url);

async function load() {
  await oniguruma.loadWASM(readFileSync(require.resolve("vscode-oniguruma/release/onig.wasm")));
  const registry = new textmate.Registry({
    onigLib: Promise.resolve({
      createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
      createOnigString: (text) => new oniguruma.OnigString(text),
    }),
    loadGrammar: () => Promise.resolve(textmate.parseRawGrammar(readFileSync(grammarFile, "utf8"), grammarFile.pathname)),
  });
  return registry.loadGrammar("source.tweeze");
}

const grammar = await load();

/** The lines of a text, each with the scopes of every column and the number of contexts open at its end. */
export function scopesOf(text) {
  let state = textmate.INITIAL;
  return text.split("\n").map((line) => {
    const { tokens, ruleStack } = grammar.tokenizeLine(line, state);
    state = ruleStack;
    const columns = tokens.flatMap(({ startIndex, endIndex, scopes }) => Array(endIndex - startIndex).fill(scopes));
    return { line, columns: columns.slice(0, line.length), depth: ruleStack.depth };
  });
}
