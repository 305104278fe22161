"""One module for each engine: `SETTINGS` from coarse to fine, and `run`, which steps a sheet and gives states and times."""
