"""Writes the graphs of tests/files/saved_graph.rs, by hnswlib and faiss. Needs both; run it in this directory."""

import gzip
import tempfile
from pathlib import Path

import faiss
import hnswlib
import numpy

ROWS, COLUMNS = 200, 12
row, column = numpy.arange(ROWS)[:, None], numpy.arange(COLUMNS)
vectors = ((row * 37 + column * 101 + row * column * 13 + row * row * 7) % 251 - 125).astype("f4")
# The labels of hnswlib are the rows, in another order than the elements.
order = numpy.random.default_rng(0).permutation(ROWS)

by_hnswlib = hnswlib.Index("l2", COLUMNS)
by_hnswlib.init_index(ROWS, M=6, ef_construction=60, random_seed=1)
by_hnswlib.add_items(vectors[order], order, num_threads=1)
faiss.omp_set_num_threads(1)
by_faiss = faiss.IndexHNSWFlat(COLUMNS, 6)
by_faiss.add(vectors)

with tempfile.TemporaryDirectory() as folder:
    by_hnswlib.save_index(f"{folder}/hnswlib.bin")
    faiss.write_index(by_faiss, f"{folder}/faiss.index")
    for file in Path(folder).iterdir():
        Path(file.name + ".gz").write_bytes(gzip.compress(file.read_bytes(), 9, mtime=0))
