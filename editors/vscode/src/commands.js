// The command lines of tweeze. Each argument is a separate string that no shell interprets, and the program follows `--`, so that a file
// of any name is taken as a file.
"use strict";

/** The arguments of a task. */
function argumentsOf({ command, file, options = [], output }) {
  const written = command === "check" ? [] : ["--output", output];
  const watch = command === "view" ? ["--watch"] : [];
  return [command, "--format", "short", ...written, ...watch, ...options, "--", file];
}

module.exports = { argumentsOf };
