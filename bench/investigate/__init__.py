"""The bench that asks: which experiment tells the explanations left apart, run and looked at until all is named."""
