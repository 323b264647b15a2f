// The programs of the repository, and the positions of their comments and strings.
import { readFileSync, readdirSync } from "node:fs";

const root = new URL("../../../../", import.meta.url);

/** Every program of a folder, by its path from the root of the repository. */
function programsOf(folder) {
  const names = readdirSync(new URL(folder, root)).filter((name) => name.endsWith(".twz"));
  return names.sort().map((name) => ({ name: folder + name, text: readFileSync(new URL(folder + name, root), "utf8") }));
}

/** The programs of docs/forms.md, in which every form of the language occurs. */
function forms() {
  const text = readFileSync(new URL("docs/forms.md", root), "utf8");
  return [...text.matchAll(/^```twz file=(\S+).*\n([^]*?)^```$/gmu)].map(([, name, program]) => ({ name: `docs/forms.md, ${name}`, text: program }));
}

/** Examples, the standard library, the templates of `tweeze new`, and every form. */
export const programs = [...["examples/", "stdlib/", "assets/templates/"].flatMap(programsOf), ...forms()];

/** The words of the language. */
export const words = JSON.parse(readFileSync(new URL("editors/words.json", root), "utf8"));

/**
 * The comments, strings, words and numbers of a line with their columns, found without the grammar; for a word, also whether it is a
 * field and whether it follows a dot.
 */
export function piecesOf(line) {
  const token = /(?<comment>\/\/.*)|(?<string>"[^"]*"?)|(?<word>[\p{Alphabetic}_][\p{Alphabetic}0-9_]*)|(?<number>[0-9][\p{Alphabetic}0-9_]*)/gu;
  return [...line.matchAll(token)].map((match) => {
    const [kind, text] = Object.entries(match.groups).find(([, found]) => found !== undefined);
    const [from, to] = [match.index, match.index + text.length];
    const isField = kind === "word" && /^\s*:/u.test(line.slice(to)) && /(^|[{},])\s*$/u.test(line.slice(0, from));
    const isMember = /(^|[^.])\.$/u.test(line.slice(0, from));
    return { kind, text, from, to, isField, isMember };
  });
}
