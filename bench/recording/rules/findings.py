"""What a rule of the format yields."""

from __future__ import annotations

Finding = tuple[str, str, bool]
"""Where in the file; what is wrong and what would be right, without full stop; whether it is only worth a note."""
