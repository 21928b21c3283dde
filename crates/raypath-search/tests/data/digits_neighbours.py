"""Writes the oracle of tests/digits.rs: the 10 nearest of every ninth digit among all 1797, as scikit-learn's brute
force finds them in float64. Needs scikit-learn; run it in this directory."""

import gzip
import numpy
import sklearn
from sklearn.datasets import load_digits
from sklearn.neighbors import NearestNeighbors

digits = load_digits().data.astype(numpy.float64)
queries = numpy.arange(0, len(digits), 9)
lines = []
for metric in ("euclidean", "cosine"):
    search = NearestNeighbors(n_neighbors=10, algorithm="brute", metric=metric).fit(digits)
    for query, row in zip(queries, search.kneighbors(digits[queries], return_distance=False)):
        lines.append(" ".join(map(str, [metric, query, *row])))
text = "\n".join(lines) + "\n"
with open("digits_neighbours.txt.gz", "wb") as file:
    file.write(gzip.compress(text.encode(), 9, mtime=0))
print(len(lines), "lines, scikit-learn", sklearn.__version__)
