"""Tables in a page between two marks, for proofs that are run bit by bit."""

from __future__ import annotations

from collections.abc import Sequence


def between(page: str, begin: str, end: str, text: str) -> str:
    """The page with ``text`` between its marks; at its end, marks and all, where it has none."""
    block = f"{begin}\n{text}\n{end}"
    if begin not in page or end not in page:
        return f"{page.rstrip()}\n\n{block}\n".lstrip("\n")
    before, rest = page.split(begin, 1)
    return before + block + rest.split(end, 1)[1]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a Markdown table."""
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]
