// The language server: one per window, started with the extension and restarted when the path of its executable changes.
"use strict";

const { LanguageClient } = require("vscode-languageclient/node");

class Server {
  /** @param {() => Promise<string | undefined>} executable finds the executable, and tells the user if there is none */
  constructor(executable) {
    this.executable = executable;
    this.client = undefined;
    // Starts and stops are serialised, however quickly they are requested.
    this.last = Promise.resolve();
  }

  /** Starts the server, after stopping one that is running. */
  restart() {
    return this.#then(async () => {
      await this.#end();
      const command = await this.executable();
      if (command === undefined) return;
      const client = new LanguageClient(
        "tweeze",
        "Tweeze",
        // Without a `transport`, the client uses standard input and output.
        { command, args: ["lsp"] },
        { documentSelector: [{ scheme: "file", language: "tweeze" }] },
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
    // A client that is starting or failed to start cannot be stopped; another may be started nevertheless.
    await client?.dispose().catch(() => {});
  }
}

module.exports = { Server };
