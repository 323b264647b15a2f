// The packed bundle in a stand-in for the editor: it loads, and talks to the language server of TWEEZE.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { Module, createRequire } from "node:module";
import test from "node:test";
import { fileURLToPath } from "node:url";

const bundle = fileURLToPath(new URL("../../dist/extension.js", import.meta.url));
const executable = process.env.TWEEZE;

class Disposable {
  constructor(end) {
    this.dispose = end ?? (() => {});
  }
  static from() {
    return new Disposable();
  }
}

class EventEmitter {
  listeners = [];
  event = (listener) => {
    this.listeners.push(listener);
    return new Disposable();
  };
  fire(event) {
    this.listeners.forEach((listener) => listener(event));
  }
  dispose() {}
}

/** Placeholder for anything that the client extends or queries in passing: a class whose members are again placeholders. */
function anything() {
  return new Proxy(class {}, {
    get: (own, key) => (key in own ? own[key] : anything()),
    apply: () => anything(),
    construct: () => ({}),
  });
}

/** An object with the members that matter; all others are placeholders, or events that never fire. */
function partly(own) {
  const isEvent = (key) => typeof key === "string" && /^on(Did|Will)/u.test(key);
  return new Proxy(own, { get: (_, key) => (key in own ? own[key] : isEvent(key) ? () => new Disposable() : anything()) });
}

/** An editor in which one program is open. */
function editor(text) {
  const done = { providers: [], findings: new EventEmitter(), errors: [] };
  const uriOf = (name) => ({ scheme: "file", fsPath: name, toString: () => `file://${name}` });
  const uri = uriOf("/lab/fetch.twz");
  const document = { uri, fileName: uri.fsPath, languageId: "tweeze", version: 1, isClosed: false, getText: () => text };
  const register = (name) => () => {
    done.providers.push(name);
    return new Disposable();
  };
  const languages = {
    match: (selector, { languageId }) => (JSON.stringify(selector).includes(languageId) ? 10 : 0),
    createDiagnosticCollection: () => ({ set: (_, found) => done.findings.fire(found), clear() {}, delete() {}, dispose() {} }),
  };
  const vscode = partly({
    version: "1.82.0",
    Disposable,
    EventEmitter,
    CancellationError: class extends Error {},
    CancellationTokenSource: class {
      token = { isCancellationRequested: false, onCancellationRequested: () => new Disposable() };
      cancel() {}
      dispose() {}
    },
    Diagnostic: class {
      constructor(range, message) {
        Object.assign(this, { range, message });
      }
    },
    DiagnosticSeverity: { Error: 0, Warning: 1, Information: 2, Hint: 3 },
    Uri: { file: uriOf, parse: (link) => uriOf(link.replace("file://", "")) },
    commands: { registerCommand: () => new Disposable(), executeCommand: async () => {} },
    env: { language: "en", appName: "stand-in", appHost: "desktop" },
    languages: new Proxy(languages, { get: (own, key) => own[key] ?? register(key) }),
    tasks: { registerTaskProvider: () => new Disposable() },
    window: partly({
      visibleTextEditors: [],
      tabGroups: partly({ all: [] }),
      showErrorMessage: async (message) => done.errors.push(message),
      createOutputChannel: () => ({ append() {}, appendLine() {}, dispose() {} }),
    }),
    workspace: partly({
      isTrusted: true,
      workspaceFolders: undefined,
      textDocuments: [document],
      notebookDocuments: [],
      getWorkspaceFolder: () => undefined,
      getConfiguration: () => ({ get: (name, otherwise) => (name === "path" ? executable : otherwise) }),
    }),
  });
  return { vscode, done };
}

/** Runs `work` with the module `name` replaced by `own`. */
function having(name, own, work) {
  const load = Module._load;
  Module._load = (wanted, ...rest) => (wanted === name ? own : load(wanted, ...rest));
  try {
    return work();
  } finally {
    Module._load = load;
  }
}

test("the bundle needs nothing but the editor", () => {
  assert.ok(existsSync(bundle), "run `npm run bundle` first");
  const { vscode } = editor("");
  const { activate, deactivate } = having("vscode", vscode, () => createRequire(import.meta.url)(bundle));
  assert.deepEqual([typeof activate, typeof deactivate], ["function", "function"]);
});

test("the client and `tweeze lsp` understand each other", { skip: executable ? false : "TWEEZE names no executable" }, async () => {
  const { vscode, done } = editor("use std.dimibot\n\ndevice bot : dimibot.femto_st\n\ntask go on bot { move to nowhere }\n");
  const require = createRequire(import.meta.url);
  delete require.cache[bundle];
  const extension = having("vscode", vscode, () => require(bundle));
  const found = new Promise((resolve) => done.findings.event(resolve));
  await extension.activate({ subscriptions: [] });
  const [first] = await found;
  assert.deepEqual([first.code, first.message.split("\n")[0]], ["E0201", "no value is named `nowhere`"]);
  for (const name of ["Completion", "Hover", "Definition", "Rename", "DocumentFormattingEdit", "FoldingRange", "CodeLens", "InlayHints"]) {
    assert.ok(done.providers.some((provider) => provider.startsWith(`register${name}`)), name);
  }
  await extension.deactivate();
  assert.deepEqual(done.errors, []);
});
