// A stand-in for the modules `vscode` and `vscode-languageclient/node`, which work only in an editor. It records all requests.
import { Module, createRequire } from "node:module";

const require = createRequire(import.meta.url);

class Task {
  constructor(definition, scope, name, source, execution, problemMatchers) {
    Object.assign(this, { definition, scope, name, source, execution, problemMatchers });
  }
}

class ProcessExecution {
  constructor(process, args, options) {
    Object.assign(this, { process, args, options });
  }
}

const fileUri = (fsPath) => ({ scheme: "file", fsPath, toString: () => `file://${encodeURI(fsPath)}` });
/** Parses a URI as the editor does: different spellings of a file's URI are equal. */
const parsed = (link) => ({ ...fileUri(decodeURI(link.replace("file://", ""))), scheme: link.split(":")[0] });

/**
 * Loads the extension into a new simulated editor.
 *
 * @param {object} given settings by name, the document in the active editor, other open documents, the workspace folder, the button that is
 *   pressed, whether the workspace is trusted, and the error with which the server fails to start
 */
export function inEditor({ settings = {}, document, others = [], folder, press, trusted = true, failing } = {}) {
  const done = { commands: new Map(), messages: [], executed: [], tasks: [], servers: [], ended: [], saved: 0, watchers: [], listeners: [], trusts: [], providers: [] };
  const workspaceFolder = folder && { uri: fileUri(folder), name: "folder", index: 0 };
  const running = [];
  const tell = (kind) => (text, ...buttons) => {
    done.messages.push({ kind, text, buttons });
    return Promise.resolve(buttons.includes(press) ? press : undefined);
  };
  const vscode = {
    Task,
    ProcessExecution,
    TaskGroup: { Build: "build group" },
    TaskScope: { Workspace: "workspace scope" },
    Uri: { file: fileUri, parse: parsed },
    commands: {
      registerCommand: (name, run) => done.commands.set(name, run),
      executeCommand: async (...all) => done.executed.push(all),
    },
    window: {
      activeTextEditor: document && { document },
      showErrorMessage: tell("error"),
      showInformationMessage: tell("information"),
    },
    workspace: {
      isTrusted: trusted,
      textDocuments: [document, ...others].filter(Boolean),
      workspaceFolders: workspaceFolder && [workspaceFolder],
      getWorkspaceFolder: () => workspaceFolder,
      getConfiguration: (section) => ({ get: (name, otherwise) => settings[`${section}.${name}`] ?? otherwise }),
      onDidChangeConfiguration: (listener) => done.listeners.push(listener),
      onDidGrantWorkspaceTrust: (listener) => done.trusts.push(listener),
      createFileSystemWatcher: (pattern) => {
        const watcher = { pattern, isDisposed: false, dispose: () => (watcher.isDisposed = true) };
        done.watchers.push(watcher);
        return watcher;
      },
      saveAll: async () => (done.saved += 1) > 0,
    },
    tasks: {
      taskExecutions: running,
      registerTaskProvider: (sort, provider) => done.providers.push({ sort, provider }),
      executeTask: async (task) => {
        done.tasks.push(task);
        const execution = { task, terminate: () => done.ended.push(task) };
        running.push(execution);
        return execution;
      },
    },
  };
  class LanguageClient {
    constructor(id, name, server, client) {
      Object.assign(this, { id, name, server, client, state: "new" });
      done.servers.push(this);
    }
    async start() {
      if (failing) throw new Error(failing);
      this.state = "running";
    }
    async dispose() {
      if (failing) throw new Error("it never started");
      this.state = "ended";
    }
  }
  const modules = { vscode, "vscode-languageclient/node": { LanguageClient } };
  const load = Module._load;
  Module._load = (name, ...rest) => modules[name] ?? load(name, ...rest);
  try {
    for (const file of Object.keys(require.cache).filter((name) => /[\\/]src[\\/]/u.test(name))) delete require.cache[file];
    return { extension: require("../../src/extension.js"), done, vscode, settings };
  } finally {
    Module._load = load;
  }
}
