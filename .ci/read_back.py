#!/usr/bin/env python3
"""Reads a recording back with the official SDK and holds it against the trace of the same replay.

usage: read_back.py RECORDING.rrd TRACE.jsonl FEATURES.json
"""

import json
import math
import sys

import rerun as rr


def column(table, name):
    """The values of a column by frame."""
    frames = table["frame"].to_pylist()
    return {
        frame: value
        for frame, value in zip(frames, table[name].to_pylist())
        if value is not None
    }


def close(a, b):
    """Equal as 32-bit floats, which positions are in a recording."""
    return abs(a - b) <= 1e-6 * max(1.0, abs(a), abs(b))


def main(recording, trace, features):
    rows = [json.loads(line) for line in open(trace)]
    features = json.load(open(features))
    server = rr.server.Server(datasets={"run": [recording]})
    dataset = server.client().get_dataset("run")

    def read(*contents):
        return (
            dataset.filter_contents(list(contents)).reader(index="frame").to_arrow_table()
        )

    table = read("/angles/**", "/labels/**", "/world/robot/**")
    angles = {
        name: column(table, f"/angles/{name}:Scalars:scalars")
        for name in ("theta_c", "theta_i")
    }
    lanes = [name for name in table.column_names if name.startswith("/labels/")]
    sonars = sorted({name[len("/labels/") :].split(":")[0] for name in lanes})
    labels = {
        sonar: column(table, f"/labels/{sonar}:StateChange:state") for sonar in sonars
    }

    compared, wrong = 0, []
    arcs = set()
    for row in rows:
        frame, sonar = row["frame"], row["sensor"]
        place = sonars.index(sonar)
        arcs.add((frame, place))
        for name, values in angles.items():
            read_back = values[frame][place]
            expected = row[name]
            same = math.isnan(read_back) if expected is None else read_back == expected
            compared += 1
            if not same:
                wrong.append((frame, sonar, name, expected, read_back))
        compared += 1
        if labels[sonar][frame] != [row["label"]]:
            wrong.append((frame, sonar, "label", row["label"], labels[sonar][frame]))

    for name, values in angles.items():
        for frame, row in values.items():
            for place, value in enumerate(row):
                if not math.isnan(value) and (frame, place) not in arcs:
                    wrong.append((frame, sonars[place], name, "no arc", value))

    # The map as it stands at the end: every point is where the features file says.
    table = read("/world/map/points/**")
    drawn = []
    for name in table.column_names:
        if name.endswith(":Points2D:positions"):
            values = column(table, name)
            drawn += values[max(values)]
    for point in features["map"]["points"]:
        compared += 1
        # The recorded map has y as the world has it; only the view turns it over.
        if not any(close(point["x"], x) and close(point["y"], y) for x, y in drawn):
            wrong.append(("end", "map", point["id"], (point["x"], point["y"]), "absent"))

    for difference in wrong[:20]:
        print("differs:", *difference, file=sys.stderr)
    print(f"{recording}: {len(rows)} arcs, {compared} values compared, {len(wrong)} differ")
    if wrong or not rows or not drawn:
        sys.exit(1)


main(*sys.argv[1:])
