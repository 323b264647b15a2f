"""Pygments lexer for Tweeze programs (.twz)."""

from .lexer import TweezeLexer

__all__ = ["TweezeLexer"]
