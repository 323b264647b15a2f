import assert from "node:assert/strict";
import { chmodSync, mkdirSync, mkdtempSync, realpathSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import path from "node:path";
import test, { after } from "node:test";
import { inEditor } from "./stand-in.mjs";

const { find } = createRequire(import.meta.url)("../../src/executable.js");

const folder = realpathSync(mkdtempSync(path.join(tmpdir(), "tweeze-client-")));
after(() => rmSync(folder, { recursive: true }));
const executable = path.join(folder, "tweeze");
writeFileSync(executable, "#!/bin/sh\n");
chmodSync(executable, 0o755);

const documentOf = (fsPath, { languageId = "tweeze", scheme = "file" } = {}) => ({
  languageId,
  uri: { scheme, fsPath, toString: () => `${scheme}://${encodeURI(fsPath)}` },
});
const context = () => ({ subscriptions: [] });

/** The extension, activated. */
async function activated(given) {
  const editor = inEditor({ settings: { "tweeze.path": executable }, folder, ...given });
  await editor.extension.activate(context());
  return editor;
}

test("the server is `tweeze lsp`, on standard input and output without an option that says so", async () => {
  const { done, extension } = await activated();
  assert.equal(done.servers.length, 1);
  const [{ id, server, client, state }] = done.servers;
  // The client finds the setting `tweeze.trace.server` by this ID.
  assert.equal(id, "tweeze");
  assert.deepEqual(server, { command: executable, args: ["lsp"] });
  assert.deepEqual(client.documentSelector, [{ scheme: "file", language: "tweeze" }]);
  assert.equal(client.synchronize.fileEvents, done.watchers[0]);
  assert.deepEqual(done.watchers, [{ pattern: "**/*.{twz,stl}", isDisposed: false, dispose: done.watchers[0].dispose }]);
  assert.equal(state, "running");
  await extension.deactivate();
  assert.equal(done.servers[0].state, "ended");
  assert.equal(done.watchers[0].isDisposed, true);
});

test("the server starts again when its path changes, or when that is asked for", async () => {
  const { done, settings, extension } = await activated();
  const change = (name) => done.listeners.forEach((listener) => listener({ affectsConfiguration: (own) => own === name }));
  change("editor.tabSize");
  const other = path.join(folder, "other");
  writeFileSync(other, "");
  chmodSync(other, 0o755);
  settings["tweeze.path"] = other;
  change("tweeze.path");
  await done.commands.get("tweeze.restart")();
  assert.deepEqual(done.servers.map(({ server, state }) => [server.command, state]), [[executable, "ended"], [other, "ended"], [other, "running"]]);
  await extension.deactivate();
});

test("a server that does not start is a message, and the next one may", async () => {
  const { done } = await activated({ failing: "no such thing" });
  assert.deepEqual(done.messages.map(({ kind, text }) => [kind, text]), [["error", "Tweeze: the server did not start: no such thing"]]);
  await done.commands.get("tweeze.restart")();
  assert.equal(done.servers.length, 2);
});

test("a missing executable is a message whose button opens the setting", async () => {
  for (const command of [undefined, "tweeze.build", "tweeze.view", "tweeze.restart"]) {
    const { done } = await activated({ settings: { "tweeze.path": "/no/such/tweeze" }, press: "Open Setting", document: documentOf(path.join(folder, "a.twz")) });
    await new Promise(setImmediate);
    if (command) await done.commands.get(command)();
    await new Promise(setImmediate);
    const count = command ? 2 : 1;
    const message = { kind: "error", text: "Tweeze: there is no executable `/no/such/tweeze`. Install Tweeze, or set `tweeze.path` to its executable.", buttons: ["Open Setting"] };
    assert.deepEqual(done.messages, Array(count).fill(message));
    assert.deepEqual(done.executed, Array(count).fill(["workbench.action.openSettings", "tweeze.path"]));
    assert.deepEqual([done.servers, done.tasks], [[], []]);
  }
});

test("`Build This Program` saves, and starts a process without a shell whose last argument is the file", async () => {
  // Names that a shell would execute, or that a program would take for an option.
  for (const name of ["fetch.twz", "a b.twz", "$(touch x); rm -rf ~.twz", "`id`'\".twz", "--watch.twz", "–ö.twz"]) {
    const file = path.join(folder, name);
    const { done } = await activated({ document: documentOf(file) });
    await done.commands.get("tweeze.build")();
    assert.equal(done.saved, 1);
    const [{ execution, problemMatchers, group, isBackground, definition }] = done.tasks;
    assert.equal(execution.constructor.name, "ProcessExecution");
    assert.equal(execution.process, executable);
    assert.deepEqual(execution.args, ["build", "--format", "short", "--output", "out", "--", file]);
    assert.deepEqual(execution.options, { cwd: folder });
    assert.deepEqual([problemMatchers, group, isBackground], [["$tweeze"], "build group", undefined]);
    assert.deepEqual(definition, { type: "tweeze", command: "build", file });
  }
});

test("`View This Program` watches, and takes the place of the last page of the same program", async () => {
  const file = path.join(folder, "fetch.twz");
  const { done } = await activated({ document: documentOf(file), settings: { "tweeze.path": executable, "tweeze.output": "plans" } });
  await done.commands.get("tweeze.view")();
  const [{ execution, problemMatchers, isBackground }] = done.tasks;
  assert.deepEqual(execution.args, ["view", "--format", "short", "--output", "plans", "--watch", "--", file]);
  assert.deepEqual([problemMatchers, isBackground], [[], true]);
  await done.commands.get("tweeze.build")();
  assert.deepEqual(done.ended, []);
  await done.commands.get("tweeze.view")();
  assert.deepEqual(done.ended, [done.tasks[0]]);
});

test("the commands over a task build and show it alone, whichever editor is active", async () => {
  const file = path.join(folder, "a µ.twz");
  const document = documentOf(file);
  const { done } = await activated({ document: documentOf(path.join(folder, "b.twz")), others: [document] });
  // Arguments as the server sends them, with the URI as the editor gave it or in another spelling.
  for (const link of [document.uri.toString(), `file://${file}`]) await done.commands.get("tweeze.build")(link, "fetch");
  await done.commands.get("tweeze.view")(document.uri.toString(), "fetch");
  assert.deepEqual(done.tasks.map(({ execution }) => execution.args), [
    ["build", "--format", "short", "--output", "out", "--task", "fetch", "--", file],
    ["build", "--format", "short", "--output", "out", "--task", "fetch", "--", file],
    ["view", "--format", "short", "--output", "out", "--watch", "--task", "fetch", "--", file],
  ]);
  assert.deepEqual(done.tasks[0].definition, { type: "tweeze", command: "build", file, options: ["--task", "fetch"] });
  // A document that has been closed since.
  await done.commands.get("tweeze.build")("file:///gone.twz", "fetch");
  assert.deepEqual([done.tasks.length, done.messages.map(({ text }) => text)], [3, ["Tweeze: open a program (`.twz`) first."]]);
  // A menu of the editor passes its own object.
  await done.commands.get("tweeze.build")(document.uri);
  assert.deepEqual(done.tasks[3].execution.args, ["build", "--format", "short", "--output", "out", "--", path.join(folder, "b.twz")]);
});

test("without a program in a file, the commands say what is needed", async () => {
  const cases = [
    [undefined, "Tweeze: open a program (`.twz`) first."],
    [documentOf("/a.rs", { languageId: "rust" }), "Tweeze: open a program (`.twz`) first."],
    [documentOf("Untitled-1", { scheme: "untitled" }), "Tweeze: save the program to a file first."],
  ];
  for (const [document, text] of cases) {
    const { done } = await activated({ document });
    await done.commands.get("tweeze.build")();
    assert.deepEqual(done.messages.map((message) => message.text), [text]);
    assert.deepEqual(done.tasks, []);
  }
});

test("in a workspace that is not trusted nothing runs, until it is", async () => {
  const { done } = await activated({ trusted: false, document: documentOf(path.join(folder, "a.twz")) });
  await done.commands.get("tweeze.build")();
  await done.commands.get("tweeze.restart")();
  assert.deepEqual([done.servers, done.tasks, done.providers, done.messages.length], [[], [], [], 2]);
  await done.trusts[0]();
  assert.equal(done.servers.length, 1);
});

test("tasks are offered for the open program, and those of tasks.json are completed", async () => {
  const file = path.join(folder, "sub", "fetch.twz");
  const { done, vscode } = await activated({ document: documentOf(file) });
  const [{ sort, provider }] = done.providers;
  assert.equal(sort, "tweeze");
  const offered = await provider.provideTasks();
  assert.deepEqual(offered.map(({ name, definition }) => [name, definition]), [
    ["build fetch.twz", { type: "tweeze", command: "build", file: path.join("sub", "fetch.twz") }],
    ["check fetch.twz", { type: "tweeze", command: "check", file: path.join("sub", "fetch.twz") }],
  ]);
  assert.deepEqual(offered[1].execution.args, ["check", "--format", "short", "--", file]);
  const definition = { type: "tweeze", command: "build", file: "sub/fetch.twz", options: ["--emit", "mcap,html"] };
  const resolved = await provider.resolveTask(new vscode.Task(definition, vscode.workspace.workspaceFolders[0], "mine", "tweeze"));
  assert.equal(resolved.definition, definition);
  assert.equal(resolved.name, "mine");
  assert.deepEqual(resolved.execution.args, ["build", "--format", "short", "--output", "out", "--emit", "mcap,html", "--", file]);
  for (const wrong of [{ type: "tweeze", command: "explode", file: "a" }, { type: "tweeze", command: "build" }, { type: "tweeze", command: "toString", file: "a" }]) {
    assert.equal(await provider.resolveTask(new vscode.Task(wrong, undefined, "x", "tweeze")), undefined);
  }
});

test("an executable is found by name in PATH, by path, and in no other way", async () => {
  const machine = { env: { PATH: ["", ".", folder].join(path.delimiter) }, platform: process.platform, home: folder, folder };
  mkdirSync(path.join(folder, "bin", "tweeze"), { recursive: true });
  writeFileSync(path.join(folder, "plain"), "");
  chmodSync(path.join(folder, "plain"), 0o644);
  const cases = [
    ["tweeze", executable],
    [" tweeze ", executable],
    [executable, executable],
    ["./tweeze", executable],
    ["~/tweeze", executable],
    ["${workspaceFolder}/tweeze", executable],
    ["", undefined],
    ["tweez", undefined],
    // A folder, and a file that is not executable.
    ["bin/tweeze", undefined],
    ["./plain", undefined],
    ["plain", undefined],
  ];
  for (const [wanted, expected] of cases) assert.equal(await find(wanted, machine), expected, wanted);
  assert.equal(await find("./tweeze", { ...machine, folder: undefined }), undefined);
  assert.equal(await find("tweeze", { ...machine, env: {} }), undefined);
});
