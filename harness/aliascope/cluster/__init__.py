"""Jobs on the workers of a dask.distributed cluster: `client` sends them, `work` does them where they arrive, `server`
is the worker that `aliascope worker` starts.

A worker has a resource for each renderer that it can draw with, whose name holds a hash of that renderer's versions and
code: the scheduler gives it nothing else, so no picture is made by other versions than its key says. A job is done in a
process of its worker's, as locally: one that crashes or hangs is that job's failure, and the worker goes on.
"""
