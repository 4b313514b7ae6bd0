#!/usr/bin/env python3
"""Registers recordings in one catalog and reads all rows back: none may hide another's.

usage: catalog.py RECORDING.rrd RECORDING.rrd ..
"""

import sys

import rerun as rr


def rows(recordings):
    server = rr.server.Server(datasets={"drives": recordings})
    dataset = server.client().get_dataset("drives")
    return dataset.reader(index="frame").to_arrow_table().num_rows


alone = [rows([recording]) for recording in sys.argv[1:]]
together = rows(sys.argv[1:])
print(f"{len(alone)} recordings: {alone} rows each, {together} together")
sys.exit(together != sum(alone) or min(alone) == 0)
