// The language server: one for the window, started with the extension and again when its executable changes.
"use strict";

const { LanguageClient } = require("vscode-languageclient/node");

class Server {
  /** @param {() => Promise<string | undefined>} executable finds it, and tells the user where there is none */
  constructor(executable) {
    this.executable = executable;
    this.client = undefined;
    // Starts and stops follow one another, however fast they are asked for.
    this.last = Promise.resolve();
  }

  /** Starts it, or ends it and starts it again. */
  restart() {
    return this.#then(async () => {
      await this.#end();
      const command = await this.executable();
      if (command === undefined) return;
      const client = new LanguageClient(
        "tweeze",
        "Tweeze",
        // Standard input and output are what is used where no transport is named.
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
    // What failed was told to who asked; it must not keep the next start from its turn.
    this.last = done.catch(() => {});
    return done;
  }

  async #end() {
    const client = this.client;
    this.client = undefined;
    // One that is still starting, or has failed to, cannot be stopped, which is no reason not to start another.
    await client?.dispose().catch(() => {});
  }
}

module.exports = { Server };
