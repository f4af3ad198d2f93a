#!/usr/bin/env python3
"""Writes one recording in the formats that its programs write by default: make.py FOLDER (needs numpy, pyarrow and mcap).

The recording is synthetic: 1 s at 1 kHz, 5 mm/s, 120 N/m, a fall of 0.3 N after 0.7 s, noise of 0.5 mN.
"""
import json, pathlib, sys
import numpy as np, pyarrow as pa, pyarrow.parquet as pq
from mcap.writer import CompressionType, Writer

out = pathlib.Path(sys.argv[1])
t = np.arange(1000) / 1000
x = np.round(0.005 * t, 9)
f = np.round(120 * x - np.where(t > 0.7, 0.3, 0) + 0.0005 * np.random.default_rng(0).standard_normal(1000), 5)

np.savez_compressed(out / "arrays.npz", time_s=t, position_m=x, force_n=f)
np.save(out / "matrix.npy", np.c_[t, x, f])
fields = [("stamp", "datetime64[ns]"), ("label", "U4"), ("position_m", "f4"), ("force_n", ">f8")]
records = np.zeros(1000, fields)
records["stamp"] = np.datetime64("2026-01-01T00:00:00", "ns") + (t * 1e9).round().astype("timedelta64[ns]")
records["position_m"], records["force_n"] = x, f
np.save(out / "records.npy", records)

table = pa.table({"time_s": t, "position_m": x, "force_n": f})
for codec in ("zstd", "brotli", "lz4", "gzip", "snappy"):
    pq.write_table(table, out / f"{codec}.parquet", compression=codec)
pq.write_table(table, out / "zstd_v2.parquet", compression="zstd", data_page_version="2.0")
stamps = pa.array((t * 1e9).round().astype("int64") + 1767225600 * 10**9, pa.timestamp("ns"))
lists = pa.table({"timestamp": stamps, "state": pa.array(np.c_[x, f].tolist()), "task": ["cut"] * 1000})
pq.write_table(lists, out / "lists.parquet")

for codec in (CompressionType.ZSTD, CompressionType.LZ4):
    with open(out / f"{codec.name.lower()}.mcap", "wb") as file:
        writer = Writer(file, compression=codec)
        writer.start()
        schema = writer.register_schema("Sample", "jsonschema", b'{"type":"object"}')
        pose = writer.register_channel("/pose", "json", schema)
        wrench = writer.register_channel("/wrench", "json", schema)
        # The pose has a tenth of the rate, and begins 50 ms later.
        for k, (time, position, force) in enumerate(zip(t, x, f)):
            log_time = int(round(time * 1e9)) + 10**18
            if k >= 50 and k % 10 == 0:
                writer.add_message(pose, log_time, json.dumps({"position": {"x": 0.4, "z": position}}).encode(), log_time)
            message = {"force": {"x": 0.0, "z": force}, "torque": {"z": 0.01 * force}}
            writer.add_message(wrench, log_time, json.dumps(message).encode(), log_time)
        writer.finish()
