"""Writes tweeze_pygments/words.py from ../words.json."""

import json
from pathlib import Path

HERE = Path(__file__).resolve().parent
WORDS = HERE.parent.parent / "words.json"
MODULE = HERE.parent / "tweeze_pygments" / "words.py"


def text() -> str:
    """The text of the generated module."""
    words = json.loads(WORDS.read_text(encoding="utf-8"))
    lines = ['"""The words of the language. Written by scripts/words.py from ../words.json."""', ""]
    for name, own in words.items():
        lines.append(f"{name.upper()} = (")
        lines.extend(f"    {json.dumps(word, ensure_ascii=False)}," for word in own)
        lines.append(")")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    MODULE.write_text(text(), encoding="utf-8")
