// Tweeze in Visual Studio Code: the client of `tweeze lsp`, and the commands that build and show a program.
"use strict";

const os = require("node:os");
const vscode = require("vscode");
const { find } = require("./executable");
const { Server } = require("./server");
const tasks = require("./tasks");

const OPEN_SETTING = "Open Setting";

let server;

function wantedExecutable(scope) {
  return vscode.workspace.getConfiguration("tweeze", scope).get("path", "tweeze");
}

function foundExecutable(scope) {
  const folders = vscode.workspace.workspaceFolders;
  const folder = (scope && vscode.workspace.getWorkspaceFolder(scope)) ?? folders?.[0];
  const machine = { env: process.env, platform: process.platform, home: os.homedir(), folder: folder?.uri.fsPath };
  return find(wantedExecutable(scope), machine);
}

/** The executable; if there is none, undefined, with a message that leads to the setting. */
async function executableOrMessage(scope) {
  const found = await foundExecutable(scope);
  if (found === undefined) tellMissing(scope);
  return found;
}

async function tellMissing(scope) {
  const wanted = wantedExecutable(scope);
  const how = "Install Tweeze, or set `tweeze.path` to its executable.";
  const chosen = await vscode.window.showErrorMessage(`Tweeze: there is no executable \`${wanted}\`. ${how}`, OPEN_SETTING);
  if (chosen === OPEN_SETTING) await vscode.commands.executeCommand("workbench.action.openSettings", "tweeze.path");
}

/**
 * Saves all files and returns the program's URI; undefined, with a message if there is no program to save.
 *
 * @param {string | undefined} link URI of the program with the task whose code lens was clicked; if undefined, the active editor's program
 */
async function savedProgram(link) {
  const isMeant = (document) => document.uri.toString() === vscode.Uri.parse(link).toString();
  const document = link === undefined ? vscode.window.activeTextEditor?.document : vscode.workspace.textDocuments.find(isMeant);
  if (!document || document.languageId !== "tweeze") {
    vscode.window.showInformationMessage("Tweeze: open a program (`.twz`) first.");
    return undefined;
  }
  if (document.uri.scheme !== "file") {
    vscode.window.showInformationMessage("Tweeze: save the program to a file first.");
    return undefined;
  }
  // Programs use other files, so these are saved too.
  if (!(await vscode.workspace.saveAll(false))) return undefined;
  return document.uri;
}

/**
 * Runs a command of tweeze on the program in the active editor, or on a task of it.
 *
 * @param {unknown} link from a code lens over a task, the URI of the program as a string; from a menu, an object of the editor
 * @param {unknown} name the name of that task
 */
async function run(command, link, name) {
  const isOfTask = typeof link === "string" && typeof name === "string";
  const uri = await savedProgram(isOfTask ? link : undefined);
  if (uri === undefined) return undefined;
  const executable = await executableOrMessage(uri);
  if (executable === undefined) return undefined;
  const options = isOfTask ? { options: ["--task", name] } : {};
  const definition = { type: tasks.SORT, command, file: uri.fsPath, ...options };
  const task = tasks.taskOf(definition, vscode.workspace.getWorkspaceFolder(uri), executable);
  // Only one task may watch a program for its page: the new task replaces the old one.
  if (command === "view") {
    const isSame = ({ task: other }) => other.source === tasks.SORT && other.definition.command === "view" && other.definition.file === uri.fsPath;
    vscode.tasks.taskExecutions.filter(isSame).forEach((execution) => execution.terminate());
  }
  return vscode.tasks.executeTask(task);
}

/** Restarts the server; if that fails, a message says why. */
async function restart() {
  try {
    await server.restart();
  } catch (error) {
    vscode.window.showErrorMessage(`Tweeze: the server did not start: ${error instanceof Error ? error.message : error}`);
  }
}

function activateTrusted(context) {
  server = new Server(() => executableOrMessage());
  const executable = async (scope) => (await foundExecutable(scope)) ?? wantedExecutable(scope);
  context.subscriptions.push(
    vscode.tasks.registerTaskProvider(tasks.SORT, tasks.provider(executable)),
    vscode.workspace.onDidChangeConfiguration((event) => {
      if (event.affectsConfiguration("tweeze.path")) restart();
    }),
  );
  return restart();
}

async function activate(context) {
  const ifTrusted = (work) => (...given) => {
    if (vscode.workspace.isTrusted) return work(...given);
    return vscode.window.showInformationMessage("Tweeze: programs are built, and the server runs, in trusted workspaces only.");
  };
  context.subscriptions.push(
    vscode.commands.registerCommand("tweeze.build", ifTrusted((...of) => run("build", ...of))),
    vscode.commands.registerCommand("tweeze.view", ifTrusted((...of) => run("view", ...of))),
    vscode.commands.registerCommand("tweeze.restart", ifTrusted(restart)),
  );
  if (vscode.workspace.isTrusted) await activateTrusted(context);
  else context.subscriptions.push(vscode.workspace.onDidGrantWorkspaceTrust(() => activateTrusted(context)));
}

function deactivate() {
  return server?.stop();
}

module.exports = { activate, deactivate };
