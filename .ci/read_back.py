#!/usr/bin/env python3
"""Reads a recording back with the official SDK and holds it against the trace of the same replay.

usage: read_back.py RECORDING.rrd TRACE.jsonl FEATURES.json

What decided must be equal, and labels to the letter; places are 32-bit floats in a recording.
"""

import json
import math
import sys
from collections import defaultdict

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
    return abs(a - b) <= 1e-5 + 1e-6 * max(abs(a), abs(b))


def main(recording, trace, features):
    rows = [json.loads(line) for line in open(trace)]
    text = open(features).read()
    features = json.loads(text)
    server = rr.server.Server(datasets={"run": [recording]})
    dataset = server.client().get_dataset("run")

    def read(*contents, index="frame"):
        view = dataset.filter_contents(list(contents))
        return view.reader(index=index).to_arrow_table()

    compared, wrong = 0, []

    def check(same, *what):
        nonlocal compared
        compared += 1
        if not same:
            wrong.append(what)

    # Far from the world's origin a recording has one of its own.
    properties = dataset.segment_table().to_arrow_table()
    name = "property:origin:Scalars:scalars"
    ox, oy = (0.0, 0.0)
    if name in properties.column_names:
        ox, oy = properties[name].to_pylist()[0]

    table = read("/angles/**", "/chi2/**", "/labels/**", "/world/beams")
    by_noise = features["config"]["rule"] == "noise-aware"
    bounds = features["config"]["opinion"]

    def lead(row):
        """Of the widest window, as it is plotted: cut at the edges of the plot."""
        line, point = row["wide_chi2_line"], row["wide_chi2_point"]
        edge = 4 * max(bounds["decisive"], bounds["gate"])
        if line is None or point is None:
            return None
        return max(-edge, min(edge, point - line))

    def smaller(row):
        return math.degrees(min(row["theta_c"], row["theta_i"]))

    plot, decided = ("/chi2/lead", lead) if by_noise else ("/angles/smaller", smaller)
    def of_sonars(path, component):
        """A column by frame of every sonar below a path, by its name."""
        found = {}
        for name in table.column_names:
            if name.startswith(path + "/") and name.endswith(component):
                sonar = name[len(path) + 1 : -len(component)].replace("\\", "")
                found[sonar] = column(table, name)
        return found

    plotted = of_sonars(plot, ":Scalars:scalars")
    labels = of_sonars("/labels", ":StateChange:state")
    beams = {}
    if "/world/beams:LineStrips2D:strips" in table.column_names:
        beams = column(table, "/world/beams:LineStrips2D:strips")

    arcs = set()
    by_frame = defaultdict(list)
    for row in rows:
        frame, sonar = row["frame"], row["sensor"]
        arcs.add((frame, sonar))
        by_frame[frame].append(row)
        value = None if row["theta_c"] is None else decided(row)
        if value is not None:
            shown = plotted[sonar][frame][0]
            check(abs(shown - value) <= 1e-6, frame, sonar, plot, value, shown)
        label = row["label"] if row["reason"] is None else f"{row['label']}: {row['reason']}"
        shown = labels[sonar][frame]
        if row["suspect"]:
            label += ", suspect"
        check(shown == [label], frame, sonar, "label", label, shown)

    for sonar, values in plotted.items():
        for frame in values:
            check((frame, sonar) in arcs, frame, sonar, plot, "no arc")

    # A ray leads from each sonar to the middle of its arc.
    for frame, expected in by_frame.items():
        check(len(beams[frame]) == len(expected), frame, "beams", len(expected))
        for row, (start, end) in zip(expected, beams[frame]):
            x, y = row["x"] - ox, row["y"] - oy
            at = (x, y)
            to = (
                x + row["range"] * math.cos(row["yaw"]),
                y + row["range"] * math.sin(row["yaw"]),
            )
            same = all(map(close, start, at)) and all(map(close, end, to))
            check(same, frame, row["sensor"], "beam", at, to, start, end)

    # The map as it stands at the end.
    drawn = {"points": [], "lines": []}
    table = read("/world/map/**")
    for name in table.column_names:
        for kind, ending in (
            ("points", ":Points2D:positions"),
            ("lines", ":LineStrips2D:strips"),
        ):
            if name.startswith(f"/world/map/{kind}") and name.endswith(ending):
                values = column(table, name)
                drawn[kind] += values[max(values)]
    for point in features["map"]["points"]:
        at = (point["x"] - ox, point["y"] - oy)
        check(any(all(map(close, at, p)) for p in drawn["points"]), "map point", point["id"], at)
    for line in features["map"]["lines"]:
        along = (-math.sin(line["theta"]), math.cos(line["theta"]))
        ends = [
            [
                m - o + sign * line["half_length"] * a
                for m, o, a in zip(line["mid"], (ox, oy), along)
            ]
            for sign in (-1, 1)
        ]
        same = any(
            all(any(all(map(close, end, p)) for p in strip) for end in ends)
            for strip in drawn["lines"]
        )
        check(same, "map line", line["id"], ends)

    # The features file is carried to the byte.
    carried = read("/run/features", index=None)["/run/features:TextDocument:text"]
    check(carried.to_pylist()[0] == [text], "features file")

    for difference in wrong[:20]:
        print("differs:", *difference, file=sys.stderr)
    print(f"{recording}: {len(rows)} arcs, {compared} values compared, {len(wrong)} differ")
    sys.exit(1 if wrong or not compared else 0)


main(*sys.argv[1:])
