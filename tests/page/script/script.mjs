// The script of a page, as a page has it: the parts in the order in which `src/emit/html/mod.rs` names them, in one scope.

import { readFileSync } from "node:fs";
import vm from "node:vm";

const root = new URL("../../../", import.meta.url);
const read = (path) => readFileSync(new URL(path, root), "utf8");

/** The names of the parts. */
export const names = [...read("src/emit/html/mod.rs").matchAll(/assets\/page\/(\w+\.js)"/g)].map(([, name]) => name);

/** The text of each part. */
export const parts = names.map((name) => ({ name, text: read(`assets/page/${name}`) }));

/** What the first part defines; it draws nothing, and needs no browser. */
export const model = (() => {
  const context = vm.createContext({});
  vm.runInContext(parts[0].text, context, { filename: names[0] });
  return context;
})();

/** A value of that part's own realm as one of this one, to be compared. */
export const plain = (value) => JSON.parse(JSON.stringify(value));
