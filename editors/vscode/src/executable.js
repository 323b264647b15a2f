// Finds the executable before it is started, so that a message can say what to do if it is missing.
"use strict";

const { constants, promises: files } = require("node:fs");
const path = require("node:path");

/** The path with `~` and `${workspaceFolder}` replaced; a name without a separator stays a name. */
function expanded(wanted, { home, folder }) {
  const inFolder = folder === undefined ? wanted : wanted.replaceAll("${workspaceFolder}", () => folder);
  return /^~(?=$|[\\/])/.test(inFolder) && home ? path.join(home, inFolder.slice(1)) : inFolder;
}

async function canRun(file) {
  try {
    // On a folder the execute bit means permission to enter.
    if (!(await files.stat(file)).isFile()) return false;
    await files.access(file, constants.X_OK);
    return true;
  } catch {
    return false;
  }
}

/**
 * The executable that a setting stands for, as an absolute path; undefined if there is none.
 *
 * @param {string} wanted a name that is looked up in PATH, or a path; a relative path is resolved against the workspace folder
 * @param {{env: object, platform: string, home: string, folder?: string}} machine
 */
async function find(wanted, machine) {
  const name = expanded(wanted.trim(), machine);
  if (name === "") return undefined;
  const isPath = /[\\/]/.test(name);
  // A relative path has no meaning without a workspace folder: nobody chose the editor's own working directory.
  if (isPath && !path.isAbsolute(name) && machine.folder === undefined) return undefined;
  const isWindows = machine.platform === "win32";
  // Windows spells the variable `Path`.
  const searched = Object.entries(machine.env).find(([key]) => (isWindows ? key.toUpperCase() : key) === "PATH")?.[1] ?? "";
  // Empty and relative entries are dropped: they would run an executable that happens to lie in an opened folder.
  const folders = isPath ? [machine.folder ?? ""] : searched.split(path.delimiter).filter((folder) => path.isAbsolute(folder));
  const endings = isWindows && path.extname(name) === "" ? [".exe", ".com"] : [""];
  for (const folder of folders) {
    for (const ending of endings) {
      const file = path.resolve(folder, name + ending);
      if (await canRun(file)) return file;
    }
  }
  return undefined;
}

module.exports = { find };
