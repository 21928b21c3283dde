"""Campaigns, proofs, design sweeps, exact searches and renders on many machines, by Dask.

``python -m raypath.cluster COMMAND …`` divides a command of ``raypath`` into shards, lets the workers of a Dask
scheduler compute them, and merges their results into the files and the text that one machine would write.
"""
