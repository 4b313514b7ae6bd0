#!/usr/bin/env python3
"""Makes the drives of docs/fleet.md, replays them, and holds the answers on that page.

usage: fleet.py TMAM [--update]

Needs duckdb, polars, pandas, pyarrow, datafusion and rerun-sdk. With --update the answers are written into the page.
"""

import contextlib
import io
import os
import re
import subprocess
import sys
import tempfile

import datafusion
import duckdb

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PAGE = os.path.join(ROOT, "docs", "fleet.md")

# As the page tells it.
ROOM = "--drive --odometry-rate 10"
DRIVES = {
    "r1-week46": "--noise 0.003 --seed 1",
    "r2-week46": "--noise 0.003 --seed 2",
    "r1-week47": "--noise 0.005 --seed 7 --needs sonar.sonar_04.yaw=98",
    "r2-week47": "--noise 0.003 --seed 4 --needs input.range_delay=0.2",
}


def answer(query):
    """What DuckDB says, as a table of text."""
    found = duckdb.sql(query)
    rows = [found.columns, *found.fetchall()]
    rows = [["-" if cell is None else str(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)
    return "\n".join(lines) + "\n"


def main(tmam, *options):
    tmam = os.path.abspath(tmam)
    page = open(PAGE).read()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        os.mkdir("drives")
        for name, faults in DRIVES.items():
            subprocess.run([tmam, "simulate", "-o", f"drives/{name}.mcap", *ROOM.split(), *faults.split()], check=True)
        subprocess.run([tmam, "replay", "drives", "-o", "out", "--arcs", "arcs"], check=True)
        # As other engines read it.
        rows = duckdb.sql("SELECT count(*) FROM 'arcs/*/*.parquet'").fetchall()[0][0]
        context = datafusion.SessionContext()
        context.register_parquet("arcs", "arcs", table_partition_cols=[("log", "string")])
        counted = context.sql("SELECT count(*), count(DISTINCT log) FROM arcs").to_pydict()
        assert [value[0] for value in counted.values()] == [rows, len(DRIVES)], counted

        def answered(block):
            return f"```sql\n{block[1]}```\n\n```text\n{answer(block[1])}```\n"

        def printed(block):
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                exec(block[1], {})
            return f"```python\n{block[1]}```\n" + (f"\n```text\n{said.getvalue()}```\n" if block[2] else "")

        new = re.sub(r"```python\n(.*?)```\n(\n```text\n.*?```\n)?", printed, page, flags=re.S)
        new = re.sub(r"```sql\n(.*?)```\n(?:\n```text\n.*?```\n)?", answered, new, flags=re.S)
    if "--update" in options:
        open(PAGE, "w").write(new)
    elif new != page:
        before, after = page.splitlines(), new.splitlines()
        differ = [line for line in after if line not in before]
        sys.exit("answers differ from docs/fleet.md:\n" + "\n".join(differ))
    print(f"{len(DRIVES)} drives, {rows} arcs: the answers of docs/fleet.md hold")


main(*sys.argv[1:])
