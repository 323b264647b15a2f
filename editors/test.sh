#!/usr/bin/env bash
# Runs the tests of all editor support and packages the extension. Needs Node 20 and a Python with pytest and Pygments.
#   PYTHON   the interpreter, python3 if not set
#   TWEEZE   the compiler's executable; without it, tests that need it are skipped
set -euo pipefail
cd "$(dirname "$0")"

python="${PYTHON:-python3}"
# Both may be paths relative to the caller's folder.
for name in python TWEEZE; do
  value="${!name:-}"
  case "$value" in
    */*) value="$(cd "$OLDPWD" && cd "$(dirname "$value")" && pwd)/$(basename "$value")"; printf -v "$name" %s "$value" ;;
  esac
done
if [ -n "${TWEEZE:-}" ]; then export TWEEZE; else echo "SKIPPED: TWEEZE names no executable; nothing is checked by the compiler"; fi

scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"' EXIT
say() { printf '\n== %4d s  %s\n' "$SECONDS" "$*"; }

say "Visual Studio Code: grammar, snippets, client"
(cd vscode && npm ci --ignore-scripts --no-fund --no-audit && npm test)

say "Visual Studio Code: the package"
(cd vscode && npm run package 2>&1 | tee "$scratch/package.log")
if grep -E "WARN|ERROR" "$scratch/package.log"; then exit 1; fi
# The package holds all that an editor reads, and nothing else.
"$python" - vscode/tweeze.vsix <<'CHECK'
import sys, zipfile
names = sorted(name for name in zipfile.ZipFile(sys.argv[1]).namelist() if name.startswith("extension/"))
wanted = ["dist/extension.js", "language-configuration.json", "package.json", "readme.md", "snippets/tweeze.json", "syntaxes/tweeze.tmLanguage.json"]
assert names == [f"extension/{name}" for name in wanted], names
CHECK

say "highlight.js"
(cd highlightjs && npm ci --ignore-scripts --no-fund --no-audit && npm test)

say "Pygments"
# Installed from a copy, because building leaves files behind.
cp -r pygments "$scratch/source"
"$python" -m pip install --quiet --disable-pip-version-check --no-deps --target "$scratch/site" "$scratch/source"
tests="$PWD/pygments/tests"
(cd "$scratch" && PYTHONPATH="$scratch/site" PYTHONDONTWRITEBYTECODE=1 "$python" -m pytest -q -p no:cacheprovider -o pythonpath= --rootdir "$tests" "$tests")

say "all is well"
