// The language server: one per window, started with the extension and restarted when the path of its executable changes.
"use strict";

const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

/** Files that programs read: other programs and meshes. Maps of boards are left out, since builds write JSON and SVG too. */
const READ_FILES = "**/*.{twz,stl}";

class Server {
  /** @param {() => Promise<string | undefined>} executable finds the executable, and tells the user if there is none */
  constructor(executable) {
    this.executable = executable;
    this.client = undefined;
    this.watcher = undefined;
    // Starts and stops are serialised, however quickly they are requested.
    this.last = Promise.resolve();
  }

  /** Starts the server, after stopping one that is running. */
  restart() {
    return this.#then(async () => {
      await this.#end();
      const command = await this.executable();
      if (command === undefined) return;
      this.watcher = workspace.createFileSystemWatcher(READ_FILES);
      const client = new LanguageClient(
        "tweeze",
        "Tweeze",
        // Without a `transport`, the client uses standard input and output.
        { command, args: ["lsp"] },
        {
          documentSelector: [{ scheme: "file", language: "tweeze" }],
          // The server checks open programs again when a file changes outside the editor.
          synchronize: { fileEvents: this.watcher },
        },
      );
      this.client = client;
      await client.start();
    });
  }

  stop() {
    return this.#then(() => this.#end());
  }

  #then(work) {
    const done = this.last.then(work);
    // The caller sees the failure; it must not block the next start.
    this.last = done.catch(() => {});
    return done;
  }

  async #end() {
    const client = this.client;
    this.client = undefined;
    this.watcher?.dispose();
    this.watcher = undefined;
    // A client that is starting or failed to start cannot be stopped; another may be started nevertheless.
    await client?.dispose().catch(() => {});
  }
}

module.exports = { Server };
