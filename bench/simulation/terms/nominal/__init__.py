"""The terms of the nominal simulation: each can be switched off, and then found missing."""
