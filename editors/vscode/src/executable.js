// Where the executable is: looked for before it is started, so that a missing one is a message that says what to do.
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
    // A folder may be entered, which is the same bit.
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
 * @param {string} wanted a name that is looked up in PATH, or a path; a relative one is taken from the workspace folder
 * @param {{env: object, platform: string, home: string, folder?: string}} machine
 */
async function find(wanted, machine) {
  const name = expanded(wanted.trim(), machine);
  if (name === "") return undefined;
  const isPath = /[\\/]/.test(name);
  // A relative path means nothing without a folder: the editor's own folder is nobody's choice.
  if (isPath && !path.isAbsolute(name) && machine.folder === undefined) return undefined;
  const isWindows = machine.platform === "win32";
  // Windows spells the variable `Path`.
  const searched = Object.entries(machine.env).find(([key]) => (isWindows ? key.toUpperCase() : key) === "PATH")?.[1] ?? "";
  // An empty entry would be the current folder: whatever lies in a folder that is opened must not be started by its name.
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
