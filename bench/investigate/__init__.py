"""Design of experiments: find the one that best separates the remaining explanations, run it, analyse again."""
