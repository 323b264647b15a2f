import importlib.util
import re
from pathlib import Path

import pytest
from pygments.lexers import get_lexer_by_name
from pygments.token import Comment, Error, Keyword, Name, Number, Operator, Punctuation, String, Token, Whitespace

from tweeze_pygments import TweezeLexer, words

PACKAGE = Path(__file__).resolve().parent.parent
ROOT = PACKAGE.parent.parent
PROGRAMS = sorted(path for folder in ("examples", "stdlib", "assets/templates") for path in (ROOT / folder).glob("*.twz"))
# Most of these programs are broken on purpose.
CASES = sorted((ROOT / "tests/corpus").rglob("*.twz"))


def name_of(path):
    return path.relative_to(ROOT).as_posix()


def pieces_of(path):
    """The text of a file, and its tokens exactly as in the text."""
    text = path.read_bytes().decode("utf-8").replace("\r\n", "\n").replace("\r", "\n")
    return text, list(TweezeLexer(stripnl=False, ensurenl=False).get_tokens(text))


def roles(text):
    """The tokens of a text, without whitespace and punctuation."""
    pieces = TweezeLexer().get_tokens(text)
    return [(own, piece) for own, piece in pieces if own not in (Whitespace, Punctuation) and piece.strip()]


def test_words_are_current():
    spec = importlib.util.spec_from_file_location("script", PACKAGE / "scripts" / "words.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    assert script.MODULE.read_text(encoding="utf-8") == script.text(), "run `python scripts/words.py`"


def test_the_programs_are_there():
    assert len(PROGRAMS) > 30
    assert len(CASES) > 100


@pytest.mark.parametrize("path", PROGRAMS, ids=name_of)
def test_programs_have_no_error(path):
    text, pieces = pieces_of(path)
    assert "".join(piece for _, piece in pieces) == text
    assert [piece for own, piece in pieces if own is Error] == []


@pytest.mark.parametrize("path", CASES, ids=name_of)
def test_nothing_of_a_broken_program_is_lost(path):
    text, pieces = pieces_of(path)
    assert "".join(piece for _, piece in pieces) == text


@pytest.mark.parametrize("path", PROGRAMS, ids=name_of)
def test_reserved_words_are_keywords_and_comments_are_not(path):
    text, pieces = pieces_of(path)
    coloured = {*words.RESERVED, *words.STEPS, *words.NOUNS, *words.STEP_NOUNS}
    at = 0
    for own, piece in pieces:
        behind = text[at + len(piece) :]
        before = text[text.rfind("\n", 0, at) + 1 : at]
        is_comment = "//" in re.sub(r'"[^"]*"', "", before + piece)
        is_string = before.count('"') % 2 == 1 or piece.startswith('"')
        is_member = re.search(r"(^|[^.])\.$", before)
        is_field = re.match(r"[ \t]*:", behind) and re.search(r"(^|[{},])[ \t]*$", before)
        is_keyword = own in Keyword and own is not Keyword.Type
        where = f"{piece!r} behind {before!r}"
        if is_comment and piece.strip():
            assert own in Comment or own is String.Doc, where
        elif piece in words.RESERVED and not is_string:
            assert is_keyword == (not is_field and not is_member), where
        elif is_keyword:
            assert piece in coloured and not is_string, where
        at += len(piece)


K, D = Keyword, Keyword.Declaration


@pytest.mark.parametrize(
    "line, expected",
    [
        (
            "use std.dimibot as d // use",
            [(K.Namespace, "use"), (Name.Namespace, "std"), (Name.Namespace, "dimibot"), (K.Namespace, "as"), (Name.Namespace, "d"), (Comment.Single, "// use")],
        ),
        ("/// for 3 um", [(String.Doc, "/// for 3 um")]),
        ("//! for 3 um", [(String.Doc, "//! for 3 um")]),
        ("//// for 3 um", [(Comment.Single, "//// for 3 um")]),
        (
            "let pitch = 70 um/s + 2 %",
            [(D, "let"), (Name.Constant, "pitch"), (Operator, "="), (Number, "70"), (K.Type, "um/s"), (Operator, "+"), (Number, "2"), (K.Type, "%")],
        ),
        (
            "device bot : d.femto_st { left: 5 }",
            [(D, "device"), (Name.Class, "bot"), (Name.Namespace, "d"), (Name.Class, "femto_st"), (Name.Attribute, "left"), (Number, "5")],
        ),
        ("output light : digital", [(D, "output"), (Name.Class, "light"), (Name.Class, "digital")]),
        (
            "task go(goal: cell) on bot in bench {",
            [(D, "task"), (Name.Function, "go"), (Name.Variable, "goal"), (K.Type, "cell"), (K, "on"), (Name, "bot"), (K, "in"), (Name, "bench")],
        ),
        (
            "program day { run go((1, 1)), wait 5 ms }",
            [(D, "program"), (Name.Function, "day"), (K, "run"), (Name.Function, "go"), (Number, "1"), (Number, "1"), (K, "wait"), (Number, "5"), (K.Type, "ms")],
        ),
        (
            "  obstacle bead : disc { radius: 0.8 µm } at pose(4.0 um, x)",
            [(D, "obstacle"), (Name.Variable, "bead"), (Name.Class, "disc"), (Name.Attribute, "radius"), (Number, "0.8"), (K.Type, "µm"), (K, "at")]
            + [(Name.Builtin, "pose"), (Number, "4.0"), (K.Type, "um"), (Name, "x")],
        ),
        (
            "  minimize distance, precision: 3 N*m",
            [(K, "minimize"), (Name.Property, "distance"), (Name.Attribute, "precision"), (Number, "3"), (K.Type, "N*m")],
        ),
        (
            "  apply state 0b1_0 for 2 s^-1",
            [(K, "apply"), (K, "state"), (Number.Bin, "0b1_0"), (K, "for"), (Number, "2"), (K.Type, "s^-1")],
        ),
        (
            "wiring bot { out -> card.port0 { gain: 2 } }",
            [(D, "wiring"), (Name, "bot"), (Name, "out"), (Operator, "->"), (Name, "card.port0"), (Name.Attribute, "gain"), (Number, "2")],
        ),
        ("  visit [state, start]", [(K, "visit"), (Name, "state"), (Name, "start")]),
        (
            '  bl[0].set -> "a{2*i}{{"',
            [(Name, "bl"), (Number, "0"), (Name, "set"), (Operator, "->"), (String.Double, '"'), (String.Double, "a"), (String.Interpol, "{")]
            + [(Number, "2"), (Operator, "*"), (Name, "i"), (String.Interpol, "}"), (String.Escape, "{{"), (String.Double, '"')],
        ),
        ("  mirrored: false, from: (2, 3)", [(Name.Attribute, "mirrored"), (K.Constant, "false"), (Name.Attribute, "from"), (Number, "2"), (Number, "3")]),
        (
            "  t: table { // of each\n  robot | u [um/s] // both\n  D1 | 3 }",
            [(Name.Attribute, "t"), (K, "table"), (Comment.Single, "// of each"), (Name.Attribute, "robot"), (Name.Attribute, "u"), (K.Type, "um/s")]
            + [(Comment.Single, "// both"), (Name, "D1"), (Number, "3")],
        ),
        (
            "for i, p in pads { move to p }",
            [(K, "for"), (Name.Variable, "i"), (Name.Variable, "p"), (K, "in"), (Name, "pads"), (K, "move"), (K, "to"), (Name, "p")],
        ),
        ("let setting = output_light", [(D, "let"), (Name.Constant, "setting"), (Operator, "="), (Name, "output_light")]),
        ("x: 0..4, 5 parsec", [(Name.Attribute, "x"), (Number, "0"), (Operator, ".."), (Number, "4"), (Number, "5"), (Name, "parsec")]),
    ],
)
def test_roles(line, expected):
    assert roles(line) == expected


def test_what_is_no_program_is_an_error_and_nothing_is_lost():
    pieces = list(TweezeLexer().get_tokens("let a = § ) ;\n"))
    assert [piece for own, piece in pieces if own is Token.Error] == ["§", ";"]
    assert "".join(piece for _, piece in pieces) == "let a = § ) ;\n"


def test_programs_are_recognised():
    assert TweezeLexer.analyse_text("//! Text\nuse std.dimibot\n") == 1.0
    assert TweezeLexer.analyse_text("task go(p: cell) on lab.bot in bench {\n") == 0.5
    assert TweezeLexer.analyse_text("use std::fmt;\nfn task() {}\n") == 0.0


def test_the_entry_point_is_the_lexer():
    metadata = (PACKAGE / "pyproject.toml").read_text(encoding="utf-8")
    assert 'tweeze = "tweeze_pygments:TweezeLexer"' in metadata
    assert (TweezeLexer.aliases, TweezeLexer.filenames) == (["tweeze", "twz"], ["*.twz"])
    try:
        from importlib.metadata import version

        version("tweeze-pygments")
    except ModuleNotFoundError:
        pytest.skip("the package is not installed")
    assert isinstance(get_lexer_by_name("twz"), TweezeLexer)
