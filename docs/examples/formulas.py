"""The table of formulas in docs/mismatch.md: what a formula in place of a free function does on recordings held out.

python docs/examples/formulas.py FOLDER_OF_FOLDERS OUT

Every folder of recordings is analysed twice, with formulas and with tables alone; both model.json are then applied to
the recordings anew, as somebody would who has nothing but the file.
"""

import json
import sys
from pathlib import Path
from typing import Any

from bench.mismatch.run import run
from bench.mismatch.unnamed import formula_proposed

CODE = "`{}`"


def analysed(folder: Path, out: Path) -> dict[str, Any]:
    """The report of a folder, which is read from its file as others read it."""
    run(folder, out)
    content: dict[str, Any] = json.loads((out / "report.json").read_text(encoding="utf-8"))
    return content


def again(folder: Path, out: Path) -> dict[str, float]:
    """RMSE of held-out recordings by channel with the model.json of ``out`` given back untouched."""
    run(folder, out / "again", out / "model.json")
    told = json.loads((out / "again" / "report.json").read_text(encoding="utf-8"))
    return {row["channel"]: row["held_out_rmse_as_given"] for row in told["channels"]}


folders = sorted(own for own in Path(sys.argv[1]).iterdir() if own.is_dir())
target = Path(sys.argv[2])
available = formula_proposed.available


def without() -> bool:
    """Formulas are not looked for."""
    return False


print("| folder | channel | formula | RMSE before | with the table | with the formula | model.json again |")
print("| --- | --- | --- | --- | --- | --- | --- |")
for folder in folders:
    formula_proposed.available = without
    tables = analysed(folder, target / folder.name / "tables")
    formula_proposed.available = available
    formulas = analysed(folder, target / folder.name / "formulas")
    given_back = again(folder, target / folder.name / "formulas")
    nameless = [own for own in formulas["findings"] if own["effect"] == "unknown"]
    for found in nameless:
        channel = found["channel"]
        before = {row["channel"]: row for row in tables["channels"]}[channel]
        after = {row["channel"]: row for row in formulas["channels"]}[channel]
        rows = [row for row in json.loads((target / folder.name / "formulas/model.json").read_text())["terms"]]
        held = [r for row in rows for r in (row, *row.get("also", ())) if r.get("form") == "formula"]
        given = any(row["equation"] in found["equation"] for row in held)
        cells = [before["held_out_rmse_before"], before["held_out_rmse_after"], after["held_out_rmse_after"]]
        numbers = [f"{own:.4g}" for own in (*cells, given_back[channel])]
        told = CODE.format(found["equation"]) if given else "the table stays"
        print("| " + " | ".join([folder.name, channel, told, *numbers]) + " |")
    if not nameless:
        print(f"| {folder.name} | none | – | – | – | – | – |")
    sys.stdout.flush()
