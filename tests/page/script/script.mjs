// The script of a page, as in the page: the parts in the order in which `src/emit/html/mod.rs` names them, in one scope.

import { readFileSync } from "node:fs";
import vm from "node:vm";

const root = new URL("../../../", import.meta.url);
const read = (path) => readFileSync(new URL(path, root), "utf8");

/** The names of the parts. */
export const names = [...read("src/emit/html/mod.rs").matchAll(/assets\/page\/(\w+\.js)"/g)].map(([, name]) => name);

/** The text of each part. */
export const parts = names.map((name) => ({ name, text: read(`assets/page/${name}`) }));

/** The global scope of the first part, which draws nothing and needs no browser. */
export const model = (() => {
  const context = vm.createContext({});
  vm.runInContext(parts[0].text, context, { filename: names[0] });
  return context;
})();

/** Copies a value from that scope's realm into this one, so that it can be compared. */
export const plain = (value) => JSON.parse(JSON.stringify(value));
