// Tasks of type `tweeze`: those of the two commands, those listed in a workspace, and those offered for the open program.
"use strict";

const path = require("node:path");
const vscode = require("vscode");
const { argumentsOf } = require("./commands");

const SORT = "tweeze";
const COMMANDS = ["build", "check", "view"];

/** The path of a definition's file; a relative path is resolved against the workspace folder. */
function fileOf(definition, folder) {
  const { file } = definition;
  return path.isAbsolute(file) ? file : path.resolve(folder?.uri.fsPath ?? ".", file);
}

/**
 * The executable task of a definition.
 *
 * @param {object} definition as in tasks.json, with `command`, `file` and perhaps `options`
 * @param {vscode.WorkspaceFolder | undefined} folder the folder to which the task belongs
 * @param {string} executable
 */
function taskOf(definition, folder, executable) {
  const file = fileOf(definition, folder);
  const { command, options } = definition;
  // The output is relative to the program's folder, wherever the task is started.
  const cwd = path.dirname(file);
  const output = vscode.workspace.getConfiguration("tweeze", vscode.Uri.file(file)).get("output", "out");
  const process = new vscode.ProcessExecution(executable, argumentsOf({ command, file, options, output }), { cwd });
  const name = `${command} ${path.basename(file)}`;
  // The page of a viewed program shows errors at their lines and is updated with each build; a list of problems would not be.
  const matchers = command === "view" ? [] : ["$tweeze"];
  const task = new vscode.Task(definition, folder ?? vscode.TaskScope.Workspace, name, SORT, process, matchers);
  if (command === "build") task.group = vscode.TaskGroup.Build;
  if (command === "view") task.isBackground = true;
  task.presentationOptions = { clear: true };
  return task;
}

/**
 * Offers `build` and `check` of the program in the active editor, and completes tasks listed in a workspace.
 *
 * @param {() => Promise<string>} executable the path of the executable, or the name that was not found, which the task then reports
 */
function provider(executable) {
  return {
    async provideTasks() {
      const document = vscode.window.activeTextEditor?.document;
      if (!document || document.languageId !== "tweeze" || document.uri.scheme !== "file") return [];
      const folder = vscode.workspace.getWorkspaceFolder(document.uri);
      // The path as the folder's tasks.json would give it.
      const file = folder ? path.relative(folder.uri.fsPath, document.uri.fsPath) : document.uri.fsPath;
      const found = await executable(document.uri);
      return ["build", "check"].map((command) => taskOf({ type: SORT, command, file }, folder, found));
    },
    async resolveTask(task) {
      const { definition, scope } = task;
      if (!COMMANDS.includes(definition.command) || typeof definition.file !== "string") return undefined;
      const folder = typeof scope === "object" ? scope : vscode.workspace.workspaceFolders?.[0];
      const found = await executable(vscode.Uri.file(fileOf(definition, folder)));
      const whole = taskOf(definition, folder, found);
      // The editor identifies its task by definition and scope, so both must be unchanged.
      const resolved = new vscode.Task(definition, scope ?? vscode.TaskScope.Workspace, task.name, SORT, whole.execution, whole.problemMatchers);
      resolved.isBackground = whole.isBackground;
      return resolved;
    },
  };
}

module.exports = { SORT, provider, taskOf };
