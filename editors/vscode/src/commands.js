// The command lines of tweeze. Each argument is a string of its own that no shell reads, and the program stands behind `--`:
// whatever a file is called, it is a file.
"use strict";

/** The arguments of a task. */
function argumentsOf({ command, file, options = [], output }) {
  const written = command === "check" ? [] : ["--output", output];
  const watch = command === "view" ? ["--watch"] : [];
  return [command, "--format", "short", ...written, ...watch, ...options, "--", file];
}

module.exports = { argumentsOf };
