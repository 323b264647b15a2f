"""The Pygments lexer for Tweeze."""

import re

from pygments.lexer import RegexLexer, bygroups, default, include, using
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Text, Whitespace

from . import words as known


def one_of(own):
    """A regex group of these words, longest first so that no word hides a longer one."""
    return f"({'|'.join(re.escape(word) for word in sorted(own, key=lambda word: (-len(word), word)))})"


WORD = r"[^\W\d]\w*"
NAME = rf"(?!{one_of(known.RESERVED).replace('(', '(?:', 1)}\b){WORD}"
PATH = rf"{NAME}(?:\.{WORD})*"
# The beginning of an entry of a block.
HEAD = r"((?:^|(?<=[{},]))[ \t]*)"
BLANKS = r"([ \t]+)"

DIGITS = r"[0-9][0-9_]*"
NUMBER = rf"{DIGITS}(?:\.{DIGITS})?(?:[eE][+-]?{DIGITS})?"
POWER = (
    rf"(?:%|(?:{'|'.join(unit for unit in known.UNITS if unit != '%')}"
    rf"|(?:{'|'.join(known.PREFIXES)})?(?:{'|'.join(known.PREFIXED_UNITS)}))\b)(?:\^-?[0-9]+)?"
)
UNIT = rf"{POWER}(?:[*/]{POWER})*"

SETTINGS = ("minimize", "require", "using")


class PathLexer(RegexLexer):
    """Lexer for dotted names such as `ea.droplet_chip`."""

    tokens = {"root": [(rf"{WORD}(?=\.)", Name.Namespace), (r"\.", Punctuation), (WORD, Name.Class)]}


class TweezeLexer(RegexLexer):
    """Lexer for Tweeze, a declarative language for micro-manipulation programs.

    Most roles follow from the position of a word in its line: a step, a noun or a field begins an entry, after the start of a line, a
    brace, or a comma outside parentheses and square brackets.
    """

    name = "Tweeze"
    aliases = ["tweeze", "twz"]
    filenames = ["*.twz"]
    mimetypes = ["text/x-tweeze"]
    flags = re.MULTILINE

    tokens = {
        "root": [include("entries"), (r"[\]})]", Punctuation)],
        "entries": [
            # Newlines come first, so that the start of the next line is recognised.
            (r"\n", Whitespace),
            include("comments"),
            (rf"{HEAD}({WORD})([ \t]*)(:)(?!=)", bygroups(Whitespace, Name.Attribute, Whitespace, Punctuation)),
            (rf"{HEAD}(use)\b", bygroups(Whitespace, Keyword.Namespace), "use"),
            (
                rf"{HEAD}(task|program){BLANKS}({NAME})([ \t]*)(\()",
                bygroups(Whitespace, Keyword.Declaration, Whitespace, Name.Function, Whitespace, Punctuation),
                "parameters",
            ),
            (
                rf"{HEAD}(task|program){BLANKS}({NAME})",
                bygroups(Whitespace, Keyword.Declaration, Whitespace, Name.Function),
            ),
            (
                rf"{HEAD}(device|instrument|output|scene){BLANKS}({NAME})",
                bygroups(Whitespace, Keyword.Declaration, Whitespace, Name.Class),
            ),
            (rf"{HEAD}(let){BLANKS}({NAME})", bygroups(Whitespace, Keyword.Declaration, Whitespace, Name.Constant)),
            (rf"{HEAD}(wiring){BLANKS}({PATH})", bygroups(Whitespace, Keyword.Declaration, Whitespace, Name)),
            (rf"{HEAD}{one_of(known.DECLARATIONS)}\b", bygroups(Whitespace, Keyword.Declaration)),
            (
                rf"{HEAD}(for){BLANKS}({NAME})(?:([ \t]*)(,)([ \t]*)({NAME}))?{BLANKS}(in)\b(?:{BLANKS}({PATH})(?=[ \t]*\{{))?",
                bygroups(
                    *(Whitespace, Keyword, Whitespace, Name.Variable, Whitespace, Punctuation, Whitespace, Name.Variable),
                    *(Whitespace, Keyword, Whitespace, Name),
                ),
            ),
            (
                rf"{HEAD}{one_of(known.NOUNS)}\b{BLANKS}({NAME})",
                bygroups(Whitespace, Keyword.Declaration, Whitespace, Name.Variable),
            ),
            (rf"{HEAD}{one_of(known.NOUNS)}\b", bygroups(Whitespace, Keyword.Declaration)),
            (rf"{HEAD}{one_of(SETTINGS)}\b{BLANKS}({NAME})", bygroups(Whitespace, Keyword, Whitespace, Name.Property)),
            (rf"{HEAD}(run){BLANKS}({PATH})", bygroups(Whitespace, Keyword, Whitespace, Name.Function)),
            (
                rf'{HEAD}{one_of(known.STEPS)}\b{BLANKS}{one_of(known.STEP_NOUNS)}\b(?=[ \t]+(?:["0-9]|{NAME}))',
                bygroups(Whitespace, Keyword, Whitespace, Keyword),
            ),
            (rf"{HEAD}{one_of(known.STEPS)}\b", bygroups(Whitespace, Keyword)),
            (r"\b(?<!\.)(table)\b([ \t]*)(\{)", bygroups(Keyword, Whitespace, Punctuation), ("table", "columns")),
            (r"[{}]", Punctuation),
            (rf"(->)([ \t]*)({PATH})", bygroups(Operator, Whitespace, Name)),
            (rf"\b(?<!\.)(in|on)\b{BLANKS}({PATH})", bygroups(Keyword, Whitespace, Name)),
            (rf"(:)(?!=)([ \t]*)({PATH})", bygroups(Punctuation, Whitespace, using(PathLexer))),
            include("reserved"),
            (rf"{PATH}(?=[ \t]*\{{)", using(PathLexer)),
            include("value"),
        ],
        "comments": [
            (r"//!.*|///(?!/).*", String.Doc),
            (r"//.*", Comment.Single),
        ],
        "reserved": [
            (rf"{one_of(known.TRUTHS)}\b", Keyword.Constant),
            (rf"{one_of(known.RESERVED)}\b", Keyword),
        ],
        # Tokens that may also occur in the braces of a string.
        "value": [
            (r"[ \t\r]+", Whitespace),
            (r'"', String.Double, "string"),
            (r"0b[01_]+\b", Number.Bin),
            (rf"({NUMBER})([ \t]*)({UNIT})", bygroups(Number, Whitespace, Keyword.Type)),
            (NUMBER, Number),
            (rf"(\.)([ \t]*)({WORD})", bygroups(Punctuation, Whitespace, Name)),
            (r"->", Operator),
            (one_of(known.OPERATORS), Operator),
            (r"=", Operator),
            (rf"{one_of(known.FUNCTIONS)}(?=[ \t]*\()", Name.Builtin),
            (rf"{WORD}(?=[ \t]*\()", Name.Function),
            (WORD, Name),
            (r"[,:]", Punctuation),
            (r"[(\[]", Punctuation, "group"),
        ],
        "group": [
            (r"[)\]]", Punctuation, "#pop"),
            (r"\n", Whitespace),
            include("comments"),
            include("reserved"),
            include("value"),
            # A brace cannot occur in brackets: it ends a bracket that was left open.
            default("#pop"),
        ],
        "use": [
            (r"(?=\n|,|//)", Text, "#pop"),
            (r"[ \t\r]+", Whitespace),
            (r'"', String.Double, "string"),
            (r"as\b", Keyword.Namespace),
            (WORD, Name.Namespace),
            (r"\.", Punctuation),
            default("#pop"),
        ],
        "parameters": [
            (r"\)", Punctuation, "#pop"),
            (r"\s+", Whitespace),
            include("comments"),
            (
                rf"({WORD})([ \t]*)(:)([ \t]*)({WORD})",
                bygroups(Name.Variable, Whitespace, Punctuation, Whitespace, Keyword.Type),
            ),
            (r",", Punctuation),
            default("#pop"),
        ],
        # The first line, which has the names of the columns.
        "columns": [
            (r"(?<=[\w\]])(?=[ \t]*(?:\n|//|\}))|(?=\})", Text, "#pop"),
            (r"\s+", Whitespace),
            # Includes the newline, so that a comment before the names does not end them.
            (r"(//.*)(\n?)", bygroups(Comment.Single, Whitespace)),
            (rf"(\[)([ \t]*)({UNIT})([ \t]*)(\])", bygroups(Punctuation, Whitespace, Keyword.Type, Whitespace, Punctuation)),
            (WORD, Name.Attribute),
            (r"\|", Punctuation),
            default("#pop"),
        ],
        "table": [
            (r"\}", Punctuation, "#pop"),
            (r"\n", Whitespace),
            (r"\|", Punctuation),
            include("comments"),
            include("reserved"),
            include("value"),
            default("#pop"),
        ],
        "string": [
            (r'"', String.Double, "#pop"),
            (r"\{\{", String.Escape),
            (r"\{", String.Interpol, "hole"),
            (r'[^"{\n]+', String.Double),
            default("#pop"),
        ],
        "hole": [
            (r"\}", String.Interpol, "#pop"),
            (r'(?=["\n])', Text, "#pop"),
            (r"[()\[\]]", Punctuation),
            include("value"),
            default("#pop"),
        ],
    }

    def analyse_text(text):
        """Confidence that a text is a Tweeze program: no other language uses `std.` with these names."""
        if re.search(r"^use std\.(dimibot|electrode_array|fingers|instruments|microrobots)\b", text, re.MULTILINE):
            return 1.0
        return 0.5 if re.search(rf"^task {WORD}.* on {PATH}( in {PATH})? \{{", text, re.MULTILINE) else 0.0
