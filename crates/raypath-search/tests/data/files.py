"""Writes the files of tests/files: arrays by NumPy and HDF5 by h5py, as other programs make them. Needs both; run it in
this directory."""

import gzip
import io
import h5py
import numpy


def write(name, data):
    with open(name + ".gz", "wb") as file:
        file.write(gzip.compress(data, 9, mtime=0))


# 7 vectors of 5 coordinates, of which each is a small multiple of a quarter.
base = numpy.array([[((row * 5 + column) * 7 % 23 - 11) / 4 for column in range(5)] for row in range(7)])
queries = base[2:5] + 0.25
difference = queries[:, None] - base[None]
distances = numpy.sqrt((difference**2).sum(axis=2))
neighbours = numpy.argsort(distances, axis=1, kind="stable")[:, :4]
distances = numpy.take_along_axis(distances, neighbours, axis=1)

for name, array in {
    "f4.npy": base.astype("<f4"),
    "f8_fortran.npy": numpy.asfortranarray(base.astype("<f8")),
    "f4_big_endian.npy": base.astype(">f4"),
    "i8.npy": neighbours.astype("<i8"),
    "u1_fortran.npy": numpy.asfortranarray((base * 4 + 11).astype("u1")),
}.items():
    buffer = io.BytesIO()
    numpy.save(buffer, array)
    write(name, buffer.getvalue())

for name, options, kind in [("plain", {}, "<f4"), ("deflated", {"compression": "gzip", "chunks": (2, 3), "shuffle": True}, "<f8")]:
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        file.attrs["type"] = "dense"
        file.attrs["distance"] = "euclidean"
        file.attrs["dimension"] = 5
        file.create_dataset("train", data=base.astype(kind), **options)
        file.create_dataset("test", data=queries.astype(kind), **options)
        file.create_dataset("neighbors", data=neighbours.astype("<i4"), **options)
        file.create_dataset("distances", data=distances.astype("<f4"), **options)
    write(name + ".hdf5", buffer.getvalue())
