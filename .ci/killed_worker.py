#!/usr/bin/env python3
"""Runs docs/fleet_on_ray.py, kills a worker in the middle of its replay, and holds what comes of it.

usage: killed_worker.py TMAM

Needs ray. The tables must be those that `tmam replay` writes alone, to the byte, and nothing else may be left.
"""

import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# The first replay dies with the worker above it, once its table is begun.
DIES = """#!/bin/sh
if mkdir died 2>/dev/null; then
  {tmam} "$@" &
  until ls arcs/.unfinished/*/.tmam-*.part >died/left 2>/dev/null; do sleep 0.01; done
  ls arcs | grep log= >died/tables
  kill -9 $PPID $! $$
fi
exec {tmam} "$@"
"""


def contents(folder):
    """All files below a folder, hidden ones too."""
    found = {}
    for place, _, files in os.walk(folder):
        for name in files:
            path = os.path.join(place, name)
            found[os.path.relpath(path, folder)] = open(path, "rb").read()
    return found


def main(tmam):
    tmam = os.path.abspath(tmam)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        logs = [f"{day}/{robot}.mcap" for day in ("monday", "tuesday") for robot in ("r1", "r2")]
        for seed, log in enumerate(logs):
            os.makedirs(os.path.dirname(log), exist_ok=True)
            drive = f"--drive --noise 0.003 --laps 3 --seed {seed}"
            subprocess.run([tmam, "simulate", "-o", log, *drive.split()], check=True)
        subprocess.run([tmam, "replay", *logs, "--arcs", "alone", "--quiet"], check=True)
        with open("none.mcap", "w") as none:
            none.write("no log")
        with open("logs.txt", "w") as listed:
            print(*logs, "none.mcap", sep="\n", file=listed)
        with open("dies", "w") as dies:
            dies.write(DIES.format(tmam=tmam))
        os.chmod("dies", 0o755)

        def on_ray(*options):
            environment = {**os.environ, "RAY_USAGE_STATS_ENABLED": "0", "RAY_AUTH_MODE": "disabled"}
            command = [sys.executable, f"{ROOT}/docs/fleet_on_ray.py", "logs.txt", "arcs", *options]
            run = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True)
            print(run.stdout, end="")
            return run

        expected = contents("alone")
        assert len(expected) == len(logs), expected.keys()
        first = on_ray("--tmam", os.path.abspath("dies"))
        assert first.returncode == 2 and first.stdout.count(" done") == len(logs), first
        assert open("died/left").read(), "nothing was begun when the worker died"
        assert contents("arcs") == expected, contents("arcs").keys()
        os.remove("arcs/log=monday_r1/arcs.parquet")
        second = on_ray("--tmam", tmam, "--missing")
        assert second.stdout.count(" done") == 1, second
        assert contents("arcs") == expected, contents("arcs").keys()
        third = on_ray("--tmam", tmam)
        assert third.stdout.count(" done") == len(logs), third
        assert contents("arcs") == expected, contents("arcs").keys()
    print("a worker died in the middle: its log was replayed again, and no half file was left")


main(*sys.argv[1:])
