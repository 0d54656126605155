"""``bench prove``: conceal effects in recordings, seal the truth, run the analyser, score what it says."""
