#!/usr/bin/env python3
"""Replays a list of logs as tasks of Ray and writes a table of arcs for each, FOLDER/log=NAME/arcs.parquet.

usage: fleet_on_ray.py LOGS.txt FOLDER [--missing] [--tmam PROGRAM] [--tries N] [flags of `tmam replay` ...]

LOGS.txt has a log a line. Every machine must see the logs and the folder under the same names, and have PROGRAM.
Ray runs the tasks on this machine, or on the cluster that RAY_ADDRESS or `ray job submit` names. A task whose worker
dies is run again; a table appears once it is whole, and the same log gives the same bytes, so that a run that was cut
off is run again as it is, or with --missing for what has no table yet. Ends as `tmam replay` does: with the exit code
of the worst log.
"""

import argparse
import collections
import os
import re
import shutil
import subprocess
import sys

import ray


class Killed(Exception):
    """tmam did not end by itself: memory ran out, or somebody ended it."""


def replay(tmam, log, table, flags):
    """Replays one log; how tmam ended, and what it said."""
    partition = os.path.dirname(table)
    unfinished = os.path.join(os.path.dirname(partition), ".unfinished", os.path.basename(partition))
    begun = os.path.join(unfinished, "arcs.parquet")
    # An attempt that died may have left half a file; should its tmam be alive, it has no name to give it any more.
    shutil.rmtree(unfinished, ignore_errors=True)
    os.makedirs(unfinished)
    command = [tmam, "replay", log, "--arcs", begun, "--quiet", *flags]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode < 0:
        raise Killed(f"{log}: tmam was ended by signal {-run.returncode}")
    if os.path.exists(begun):
        os.makedirs(partition, exist_ok=True)
        os.replace(begun, table)
    shutil.rmtree(unfinished)
    return run.returncode, run.stderr


def folder_of(name):
    """The folder of a log's table, as tmam calls it: what is neither letter nor digit as %20."""
    return "log=" + re.sub(r"[^\w.~\x80-\U0010ffff-]", lambda found: f"%{ord(found[0]):02X}", name)


def names(logs):
    """What the logs are called: as their files, with the folders before them where several are called alike."""
    words = [re.sub(r"\.mcap(\.\w+)?$", "", log).strip("/").split("/") for log in logs]
    used = [1] * len(logs)
    while True:
        called = ["_".join(of[-n:]) for of, n in zip(words, used)]
        often = collections.Counter(called)
        alike = [i for i, name in enumerate(called) if often[name] > 1 and used[i] < len(words[i])]
        if not alike:
            return called
        for i in alike:
            used[i] += 1


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("usage: ")[1])
    parser.add_argument("logs")
    parser.add_argument("folder")
    parser.add_argument("--missing", action="store_true")
    parser.add_argument("--tmam", default="tmam")
    parser.add_argument("--tries", type=int, default=4)
    options, flags = parser.parse_known_args()
    with open(options.logs) as lines:
        logs = list(dict.fromkeys(os.path.abspath(line.strip()) for line in lines if line.strip()))
    folder = os.path.abspath(options.folder)
    tables = [os.path.join(folder, folder_of(name), "arcs.parquet") for name in names(logs)]
    if len(set(tables)) < len(tables):
        sys.exit("two logs would have the same table: give one of them another name")

    ray.init(log_to_driver=False)
    task = ray.remote(replay).options(max_retries=options.tries - 1, retry_exceptions=[Killed])
    tmam = shutil.which(options.tmam) or options.tmam
    running = {
        task.remote(tmam, log, table, flags): log
        for log, table in zip(logs, tables)
        if not (options.missing and os.path.exists(table))
    }
    worst = 0
    while running:
        [done], _ = ray.wait(list(running))
        log = running.pop(done)
        try:
            code, said = ray.get(done)
        except ray.exceptions.RayError as error:
            code, said = 2, f"{options.tries} tries, and none came to its end: {error}"
        worst = max(worst, code, key=[0, 3, 1, 2].index)
        print(log, {0: "done", 2: "FAILED", 3: "incomplete"}.get(code, code), said.strip(), flush=True)
    shutil.rmtree(os.path.join(folder, ".unfinished"), ignore_errors=True)
    return worst


if __name__ == "__main__":
    sys.exit(main())
