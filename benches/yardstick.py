#!/usr/bin/env python3
"""Times whole processes on one long drive: replays, a bare walk, and `rerun mcap convert` of the official wheel.

usage: benches/yardstick.py [--hours 1] [--runs 5] [--rerun PATH] [--log FILE.mcap]

Runs from the repository's root after `cargo build --release`. The commands run in turn, so that a machine that
is busy for a while slows all of them. Prints medians, each as a multiple of the converter's, and the ratios that
docs/performance.md aims at.
"""

import argparse
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

# Sixteen sonars at 10 Hz each, odometry at 50 Hz: 756,000 messages an hour.
YARDSTICK = "--drive --firing-interval 0.00625 --odometry-rate 50 --noise 0.003 --no-truth"

REPLAYS = {
    "full": "-o {out}.rrd --features {out}.json --trace {out}.jsonl",
    "full, odometry's poses, no causes": "-o {out}.rrd --features {out}.json --trace {out}.jsonl --poses odometry --no-causes",
    "the same on one thread": "-o {out}.rrd --features {out}.json --trace {out}.jsonl --poses odometry --no-causes --jobs 1",
    "full, paper's rule": "-o {out}.rrd --features {out}.json --trace {out}.jsonl --rule paper",
    "features only": "--features {out}.json",
    "features only, odometry's poses, no causes": "--features {out}.json --poses odometry --no-causes",
    "features only, paper's rule": "--features {out}.json --rule paper",
    "table of arcs": "--arcs {out}.parquet --poses odometry --no-causes",
}

# What is held against what, by wall time and by CPU time.
RATIOS = [
    ("features only, odometry's poses, no causes", "bare walk"),
    ("full, odometry's poses, no causes", "the same on one thread"),
    ("two logs, features only, one at a time", "two logs, features only, both at a time"),
]

# Of two copies of the log.
PAIRS = {
    "two logs, features only, one at a time": "--features {out} --poses odometry --no-causes --jobs 1",
    "two logs, features only, both at a time": "--features {out} --poses odometry --no-causes --jobs 2",
}


def timed(command):
    """Wall and CPU seconds of a process, and the most memory that it held, MiB."""
    begun = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = process.stderr.read()
    _, status, used = os.wait4(process.pid, 0)
    wall = time.monotonic() - begun
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{' '.join(command)}: {process.returncode}\n{said.decode()}")
    return wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def walker():
    """The program of benches/walk.rs."""
    built = subprocess.run(
        ["cargo", "bench", "--no-run", "--bench", "walk"], stderr=subprocess.PIPE, text=True
    )
    found = re.search(r"Executable .*\((.*)\)", built.stderr)
    return found[1] if found else sys.exit(built.stderr)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--hours", default="1")
    arguments.add_argument("--runs", type=int, default=5)
    arguments.add_argument("--rerun", default=shutil.which("rerun"))
    arguments.add_argument("--tmam", default="target/release/tmam")
    arguments.add_argument("--walk", help="the program of benches/walk.rs [default: it is built]")
    arguments.add_argument("--log", help="another log [default: one that is simulated]")
    arguments.add_argument("--only", default="", help="only replays whose name holds this")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        log = given.log
        if log is None:
            log = f"{folder}/drive.mcap"
            simulate = [given.tmam, "simulate", "-o", log, "--hours", given.hours, *YARDSTICK.split()]
            wall, _, _ = timed(simulate)
            print(f"simulated {given.hours} h in {wall:.1f} s")
        print(f"{os.path.getsize(log) / 1e6:.1f} MB, {os.cpu_count()} processors\n")
        commands = {"bare walk": [given.walk or walker(), log]}
        if given.rerun:
            commands["rerun mcap convert"] = [given.rerun, "mcap", "convert", log, "-o", f"{folder}/converted.rrd"]
        for name, options in REPLAYS.items():
            if given.only in name:
                options = options.format(out=f"{folder}/out").split()
                commands[name] = [given.tmam, "replay", log, "-q", *options]
        two = [f"{folder}/{name}.mcap" for name in ("one", "two")]
        for copy in two:
            shutil.copy(log, copy)
        for name, options in PAIRS.items():
            if given.only in name:
                options = options.format(out=f"{folder}/two/").split()
                commands[name] = [given.tmam, "replay", *two, "-q", *options]
        times = {name: [] for name in commands}
        for _ in range(given.runs):
            for name, command in commands.items():
                times[name].append(timed(command))
        medians = {name: [statistics.median(of) for of in zip(*runs)] for name, runs in times.items()}
        converter = medians.get("rerun mcap convert")
        print(f"| medians of {given.runs} runs | wall s | CPU s | MiB | of the converter's wall | of its CPU |")
        print("|---|--:|--:|--:|--:|--:|")
        for name, (wall, cpu, memory) in medians.items():
            ratios = [f"{a / b:.2f}" for a, b in zip((wall, cpu), converter)] if converter else ["-", "-"]
            print(f"| {name} | {wall:.2f} | {cpu:.2f} | {memory:.0f} | {' | '.join(ratios)} |")
        print()
        for name, other in RATIOS:
            if name in medians and other in medians:
                wall, cpu = [a / b for a, b in zip(medians[name][:2], medians[other][:2])]
                print(f"{name} / {other}: {wall:.2f} of the wall time, {cpu:.2f} of the CPU time")


main()
