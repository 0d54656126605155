"""The bench that asks: which experiment best separates the explanations left, run and looked at until all is named."""
